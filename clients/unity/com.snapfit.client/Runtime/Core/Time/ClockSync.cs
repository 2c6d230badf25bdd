using System;

namespace Snapfit
{
    /// <summary>The server's time line, by this device's clock. Of every few seconds it keeps the
    /// sample with the shortest round trip, which waited least in queues (the filter of NTP), and
    /// lays a straight line through them: two crystals differ by tens of microseconds a second.
    /// </summary>
    /// <remarks>Any thread may ask or add.</remarks>
    public sealed class ClockSync
    {
        private const int Slots = 24;
        private const long SlotUs = 10000000;
        private const long DriftSpanUs = 30000000;
        private const double LargestDrift = 200e-6;
        private const double SlackUs = 20000;
        private const int StepVotes = 3;

        private readonly object gate = new object();
        private readonly ClockSample[] kept = new ClockSample[Slots];
        private int count;
        private int disagreed;
        private double originUs;
        private double offsetUs;
        private double drift;
        private bool isRestarting;

        /// <summary>Whether there is a sample.</summary>
        public bool IsSynchronised
        {
            get
            {
                lock (gate)
                {
                    return count > 0;
                }
            }
        }

        /// <summary>How wrong the offset is at most: half the shortest round trip, microseconds.
        /// </summary>
        public double UncertaintyUs
        {
            get
            {
                lock (gate)
                {
                    return count == 0 ? double.PositiveInfinity : 0.5 * ShortestUs();
                }
            }
        }

        /// <summary>Microseconds by which the server's clock gains on this one, each second.
        /// </summary>
        public double DriftPpm
        {
            get
            {
                lock (gate)
                {
                    return 1e6 * drift;
                }
            }
        }

        /// <summary>The server's time at a time of this device's clock, microseconds. Before the
        /// first sample it is the device's own.</summary>
        public long ServerUs(long clientUs)
        {
            lock (gate)
            {
                return clientUs + (long)(offsetUs + drift * (clientUs - originUs));
            }
        }

        /// <summary>The server may be another one now: the next sample counts alone. Until it
        /// comes, the old time line goes on.</summary>
        public void Restart()
        {
            lock (gate)
            {
                isRestarting = true;
            }
        }

        /// <summary>Takes a sample in. Three in a row that cannot be of this time line begin a new
        /// one.</summary>
        public void Add(ClockSample sample)
        {
            if (sample.RoundTripUs < 0)
            {
                return;
            }
            lock (gate)
            {
                bool fits = count == 0 || Fits(sample);
                disagreed = fits ? 0 : disagreed + 1;
                if (isRestarting || disagreed >= StepVotes)
                {
                    count = 0;
                    disagreed = 0;
                    isRestarting = false;
                    fits = true;
                }
                if (fits)
                {
                    Keep(sample);
                    Fit();
                }
            }
        }

        private bool Fits(ClockSample sample)
        {
            double expected = offsetUs + drift * (sample.ClientReceivedUs - originUs);
            double room = 0.5 * (sample.RoundTripUs + ShortestUs()) + SlackUs;
            return Math.Abs(sample.OffsetUs - expected) <= room;
        }

        private void Keep(ClockSample sample)
        {
            long slot = sample.ClientReceivedUs / SlotUs;
            if (count > 0 && kept[count - 1].ClientReceivedUs / SlotUs == slot)
            {
                if (sample.RoundTripUs <= kept[count - 1].RoundTripUs)
                {
                    kept[count - 1] = sample;
                }
                return;
            }
            if (count == Slots)
            {
                Array.Copy(kept, 1, kept, 0, Slots - 1);
                count--;
            }
            kept[count++] = sample;
        }

        /// <summary>Weighted least squares of offset over time; weights fall with the square of
        /// the round trip, which bounds the error.</summary>
        private void Fit()
        {
            double weights = 0;
            double meanUs = 0;
            double meanOffset = 0;
            for (int place = 0; place < count; place++)
            {
                double weight = Weight(kept[place]);
                weights += weight;
                meanUs += weight * (kept[place].ClientReceivedUs - kept[0].ClientReceivedUs);
                meanOffset += weight * (kept[place].OffsetUs - kept[0].OffsetUs);
            }
            originUs = kept[0].ClientReceivedUs + meanUs / weights;
            offsetUs = kept[0].OffsetUs + meanOffset / weights;
            drift = 0;
            if (kept[count - 1].ClientReceivedUs - kept[0].ClientReceivedUs < DriftSpanUs)
            {
                return;
            }
            double covariance = 0;
            double variance = 0;
            for (int place = 0; place < count; place++)
            {
                double weight = Weight(kept[place]);
                double awayUs = kept[place].ClientReceivedUs - originUs;
                covariance += weight * awayUs * (kept[place].OffsetUs - offsetUs);
                variance += weight * awayUs * awayUs;
            }
            drift = Math.Max(-LargestDrift, Math.Min(LargestDrift, covariance / variance));
        }

        private static double Weight(ClockSample sample)
        {
            double error = 100 + sample.RoundTripUs;
            return 1 / (error * error);
        }

        private long ShortestUs()
        {
            long shortest = long.MaxValue;
            for (int place = 0; place < count; place++)
            {
                shortest = Math.Min(shortest, kept[place].RoundTripUs);
            }
            return shortest;
        }
    }
}
