using System;

namespace Snapfit
{
    /// <summary>How long to wait before the next try: twice as long each time up to a limit, of
    /// which a random half is taken off, so that fifty headsets do not come back at once.
    /// </summary>
    public sealed class Backoff
    {
        private readonly double firstS;
        private readonly double limitS;
        private readonly Random random;
        private int tries;

        /// <summary>From the first wait to the longest.</summary>
        /// <param name="firstS">The first wait, seconds.</param>
        /// <param name="limitS">No wait is longer, seconds.</param>
        /// <param name="random">Where chance comes from.</param>
        public Backoff(double firstS, double limitS, Random random)
        {
            if (!(firstS > 0) || !(limitS >= firstS))
            {
                throw new ArgumentException("Waits are positive, and the limit is the longest.");
            }
            this.firstS = firstS;
            this.limitS = limitS;
            this.random = random;
        }

        /// <summary>How often it failed since it went well.</summary>
        public int Tries
        {
            get { return tries; }
        }

        /// <summary>It went well: begin with the first wait again.</summary>
        public void Reset()
        {
            tries = 0;
        }

        /// <summary>The next wait.</summary>
        public TimeSpan Next()
        {
            double longestS = Math.Min(limitS, firstS * Math.Pow(2, Math.Min(tries, 30)));
            tries++;
            return TimeSpan.FromSeconds(longestS * (0.5 + 0.5 * random.NextDouble()));
        }
    }
}
