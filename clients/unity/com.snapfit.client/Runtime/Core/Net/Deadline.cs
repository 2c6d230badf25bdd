using System;
using System.Threading;

namespace Snapfit
{
    /// <summary>How long a request may take, within what its caller allows.</summary>
    internal sealed class Deadline : IDisposable
    {
        private readonly CancellationTokenSource source;
        private readonly CancellationToken caller;
        private readonly double limitS;

        public Deadline(double limitS, CancellationToken caller)
        {
            this.limitS = limitS;
            this.caller = caller;
            source = CancellationTokenSource.CreateLinkedTokenSource(caller);
            source.CancelAfter(TimeSpan.FromSeconds(limitS));
        }

        public CancellationToken Token
        {
            get { return source.Token; }
        }

        /// <summary>What to tell of an exception of the network: that the caller ended it, that
        /// it took too long, or what else went wrong.</summary>
        public Exception Explain(Exception error, Uri address)
        {
            if (caller.IsCancellationRequested)
            {
                return new OperationCanceledException(caller);
            }
            if (source.IsCancellationRequested)
            {
                return new UnreachableException(
                    "No answer from " + address + " within " + limitS + " s.", error);
            }
            Exception cause = error.InnerException ?? error;
            string reason = cause.Message.Split('\n')[0].TrimEnd();
            return new UnreachableException(
                "No connection to " + address + ": " + reason + ". Does the server run, and is "
                + "this device in its network?", error);
        }

        public void Dispose()
        {
            source.Dispose();
        }
    }
}
