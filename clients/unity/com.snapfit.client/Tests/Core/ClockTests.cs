using System;

namespace Snapfit.Tests
{
    /// <summary>Clock synchronisation on simulated networks, and waits between tries.</summary>
    public static class ClockTests
    {
        private const double OffsetUs = 1795366685000000.0;

        /// <summary>Equal delays give the offset exactly; before any sample it is one's own clock.
        /// </summary>
        public static void EqualDelaysGiveTheOffset()
        {
            ClockSync clock = new ClockSync();
            Check.Equal(5L, clock.ServerUs(5), "before the first");
            Check.That(!clock.IsSynchronised, "not yet");
            clock.Add(Sample(1000, 300, 300, 0));
            Check.That(clock.IsSynchronised, "now");
            Check.Near(OffsetUs + 2000, clock.ServerUs(2000), 1, "server time");
            Check.Near(300, clock.UncertaintyUs, 1, "uncertainty");
        }

        /// <summary>The formulas of docs/conventions.md.</summary>
        public static void TheFourStamps()
        {
            ClockSample sample = new ClockSample(1000, 5300, 5400, 1900);
            Check.Near(0.5 * ((5300 - 1000) + (5400 - 1900)), sample.OffsetUs, 0, "offset");
            Check.Equal(800L, sample.RoundTripUs, "round trip");
        }

        /// <summary>Wi-Fi with queues on one side: the shortest round trip decides, and the error
        /// stays below half of it.</summary>
        public static void QueuesDoNotBendTheClock()
        {
            Random random = new Random(3);
            ClockSync clock = new ClockSync();
            for (int turn = 0; turn < 40; turn++)
            {
                long up = 1000 + (long)(60000 * Math.Pow(random.NextDouble(), 3));
                clock.Add(Sample(1000000 + 200000 * turn, up, 1000, 0));
            }
            double error = Math.Abs(clock.ServerUs(9000000) - OffsetUs - 9000000);
            Check.That(error <= clock.UncertaintyUs + 1, "error " + error);
            Check.That(error < 1500, "error " + error);
        }

        /// <summary>Crystals that differ by 50 ppm: found within some minutes, and used to look
        /// ahead.</summary>
        public static void DriftIsFound()
        {
            Random random = new Random(4);
            ClockSync clock = new ClockSync();
            for (long atUs = 0; atUs < 180000000; atUs += 2500000)
            {
                clock.Add(Sample(
                    atUs, 1000 + random.Next(3000), 1000 + random.Next(3000), 50e-6));
            }
            Check.Near(50, clock.DriftPpm, 8, "drift");
            long laterUs = 200000000;
            double wanted = OffsetUs + laterUs + 50e-6 * laterUs;
            Check.Near(wanted, clock.ServerUs(laterUs), 1500, "20 s after the last sample");
        }

        /// <summary>A server that was started anew has another clock: three samples convince.
        /// </summary>
        public static void AStepIsFollowed()
        {
            ClockSync clock = new ClockSync();
            clock.Add(Sample(0, 500, 500, 0));
            for (int turn = 1; turn <= 3; turn++)
            {
                ClockSample sample = Sample(100000 * turn, 500, 500, 0);
                clock.Add(new ClockSample(
                    sample.ClientSentUs, sample.ServerReceivedUs + 7000000,
                    sample.ServerSentUs + 7000000, sample.ClientReceivedUs));
                double wanted = OffsetUs + (turn < 3 ? 0 : 7000000);
                Check.Near(wanted, clock.ServerUs(0), 2, "after " + turn);
            }
        }

        /// <summary>A single sample that cannot be is left out; stamps in the wrong order too.
        /// </summary>
        public static void NonsenseIsLeftOut()
        {
            ClockSync clock = new ClockSync();
            clock.Add(Sample(0, 500, 500, 0));
            clock.Add(new ClockSample(1000, 0, 5000, 1001));
            ClockSample odd = Sample(100000, 500, 500, 0);
            clock.Add(new ClockSample(
                odd.ClientSentUs, odd.ServerReceivedUs - 900000, odd.ServerSentUs - 900000,
                odd.ClientReceivedUs));
            Check.Near(OffsetUs, clock.ServerUs(0), 2, "unmoved");
        }

        /// <summary>Told that the server may be another one, the next sample counts alone.
        /// </summary>
        public static void RestartForgets()
        {
            ClockSync clock = new ClockSync();
            clock.Add(Sample(0, 500, 500, 0));
            clock.Restart();
            Check.Near(OffsetUs, clock.ServerUs(0), 2, "goes on until then");
            clock.Add(new ClockSample(1000, 9000, 9000, 1200));
            Check.Near(7900 + 1000, clock.ServerUs(1000), 2, "then anew");
        }

        /// <summary>The device's own clock goes forwards, in microseconds.</summary>
        public static void TheOwnClockGoesForwards()
        {
            long before = MonotonicClock.NowUs;
            System.Threading.Thread.Sleep(30);
            long passed = MonotonicClock.NowUs - before;
            Check.That(passed >= 25000, "30 ms: " + passed + " us");
        }

        /// <summary>Waits double up to the limit, less a random half at most, and begin anew.
        /// </summary>
        public static void WaitsDoubleWithJitter()
        {
            Backoff backoff = new Backoff(0.25, 10, new Random(5));
            double longest = 0.25;
            for (int turn = 0; turn < 20; turn++)
            {
                double wait = backoff.Next().TotalSeconds;
                Check.That(wait >= 0.5 * longest - 1e-3 && wait <= longest + 1e-3, "wait " + wait);
                longest = Math.Min(10, 2 * longest);
            }
            Check.Equal(20, backoff.Tries, "tries");
            backoff.Reset();
            Check.That(backoff.Next().TotalSeconds <= 0.25, "begins anew");
            Check.Throws<ArgumentException>(() => new Backoff(0, 1, new Random(1)), "positive");
        }

        /// <summary>Fifty headsets do not come back at once.</summary>
        public static void HeadsetsComeBackOneByOne()
        {
            double least = double.MaxValue;
            double most = 0;
            for (int headset = 0; headset < 50; headset++)
            {
                double wait = new Backoff(8, 8, new Random(headset)).Next().TotalSeconds;
                least = Math.Min(least, wait);
                most = Math.Max(most, wait);
            }
            Check.That(most - least > 3, "spread " + (most - least));
        }

        private static ClockSample Sample(long sentUs, long upUs, long downUs, double drift)
        {
            long receivedUs = sentUs + upUs + 100 + downUs;
            long server = (long)(OffsetUs + sentUs + upUs + drift * (sentUs + upUs));
            return new ClockSample(sentUs, server, server + 100, receivedUs);
        }
    }
}
