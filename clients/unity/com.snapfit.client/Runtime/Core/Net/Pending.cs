using System;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>A request that is under way, for a main thread that looks once a frame and never
    /// waits.</summary>
    /// <typeparam name="T">What the request gives.</typeparam>
    public sealed class Pending<T>
    {
        private Task<T> task;

        /// <summary>Whether one is under way.</summary>
        public bool IsBusy
        {
            get { return task != null; }
        }

        /// <summary>Begin; what was under way before is not waited for any more.</summary>
        public void Begin(Task<T> request)
        {
            task = request;
        }

        /// <summary>Whether it is done; then once its result, or what went wrong.</summary>
        /// <param name="result">The default where something went wrong.</param>
        /// <param name="error">Null where nothing did.</param>
        public bool TryTake(out T result, out Exception error)
        {
            result = default(T);
            error = null;
            if (task == null || !task.IsCompleted)
            {
                return false;
            }
            Task<T> done = task;
            task = null;
            if (done.Status == TaskStatus.RanToCompletion)
            {
                result = done.Result;
            }
            else
            {
                error = done.IsCanceled
                    ? new OperationCanceledException() : done.Exception.InnerException;
            }
            return true;
        }
    }
}
