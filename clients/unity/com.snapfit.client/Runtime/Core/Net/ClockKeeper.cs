using System;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>Keeps a clock synchronised: some requests at once, then one in a few seconds.
    /// </summary>
    internal sealed class ClockKeeper
    {
        private const int Burst = 8;
        private const double BurstS = 0.05;
        private const double PeriodS = 2.5;

        private readonly SnapfitClient client;
        private readonly ClockSync clock;
        private int left = Burst;

        public ClockKeeper(SnapfitClient client, ClockSync clock)
        {
            this.client = client;
            this.clock = clock;
        }

        /// <summary>The server may be another one now: its time line counts from anew.</summary>
        public void Restart()
        {
            clock.Restart();
            Volatile.Write(ref left, Burst);
        }

        public async Task RunAsync(CancellationToken token)
        {
            try
            {
                while (true)
                {
                    try
                    {
                        clock.Add(await client.GetTimeAsync(token).ConfigureAwait(false));
                        Volatile.Write(ref left, Math.Max(0, Volatile.Read(ref left) - 1));
                    }
                    catch (SnapfitException)
                    {
                        // The feed tells it; when the server is back, it may have another clock.
                        Restart();
                    }
                    double waitS = Volatile.Read(ref left) > 0 && clock.IsSynchronised
                        ? BurstS : Volatile.Read(ref left) > 0 ? 10 * BurstS : PeriodS;
                    await Task.Delay(TimeSpan.FromSeconds(waitS), token).ConfigureAwait(false);
                }
            }
            catch (OperationCanceledException)
            {
                // Ended.
            }
        }
    }
}
