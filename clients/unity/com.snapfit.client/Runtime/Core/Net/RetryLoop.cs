using System;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>Does something that goes on until it fails, and does it again after a wait.
    /// </summary>
    internal sealed class RetryLoop
    {
        private const double RefusedS = 1;

        private readonly Backoff backoff;
        private Exception lastError;
        private int state;
        private bool wasLive;

        public RetryLoop(SnapfitOptions options, Random random)
        {
            backoff = new Backoff(options.FirstRetryS, options.LongestRetryS, random);
        }

        public FeedState State
        {
            get { return (FeedState)Volatile.Read(ref state); }
        }

        public Exception LastError
        {
            get { return Volatile.Read(ref lastError); }
        }

        public int Tries
        {
            get { return backoff.Tries; }
        }

        /// <summary>It goes well.</summary>
        public void Heard()
        {
            if (State != FeedState.Live)
            {
                backoff.Reset();
                wasLive = true;
                Set(FeedState.Live);
            }
        }

        /// <summary>Until it is ended.</summary>
        /// <param name="attempt">Goes on until it fails; calls <see cref="Heard"/>.</param>
        /// <param name="failed">Called after each failure, before the wait.</param>
        /// <param name="token">Ends it.</param>
        public async Task RunAsync(
            Func<CancellationToken, Task> attempt, Action failed, CancellationToken token)
        {
            Set(FeedState.Connecting);
            try
            {
                while (!token.IsCancellationRequested)
                {
                    TimeSpan wait = await TryOnceAsync(attempt, token).ConfigureAwait(false);
                    failed();
                    await Task.Delay(wait, token).ConfigureAwait(false);
                }
                Set(FeedState.Stopped);
            }
            catch (OperationCanceledException)
            {
                Set(FeedState.Stopped);
            }
            catch (Exception error)
            {
                // No trouble of the network, but a mistake: whoever waits for the task gets it.
                Volatile.Write(ref lastError, error);
                Set(FeedState.Failed);
                throw;
            }
        }

        private async Task<TimeSpan> TryOnceAsync(
            Func<CancellationToken, Task> attempt, CancellationToken token)
        {
            try
            {
                await attempt(token).ConfigureAwait(false);
                return TimeSpan.Zero;
            }
            catch (ProblemException error)
            {
                Volatile.Write(ref lastError, error);
                bool isBusy = error.Status >= 500 || error.Status == 429;
                Set(isBusy ? FeedState.Reconnecting : FeedState.Refused);
                TimeSpan wait = isBusy ? backoff.Next() : TimeSpan.FromSeconds(RefusedS);
                TimeSpan told = TimeSpan.FromSeconds(error.RetryAfterS ?? 0);
                return told > wait ? told : wait;
            }
            catch (SnapfitException error)
            {
                Volatile.Write(ref lastError, error);
                Set(wasLive ? FeedState.Reconnecting : FeedState.Connecting);
                return backoff.Next();
            }
        }

        private void Set(FeedState next)
        {
            Volatile.Write(ref state, (int)next);
        }
    }
}
