using System.Diagnostics;

namespace Snapfit
{
    /// <summary>This device's own clock, which never jumps.</summary>
    public static class MonotonicClock
    {
        private const double MicrosecondsASecond = 1e6;

        /// <summary>Microseconds since some moment in the past.</summary>
        public static long NowUs
        {
            get
            {
                double seconds = (double)Stopwatch.GetTimestamp() / Stopwatch.Frequency;
                return (long)(MicrosecondsASecond * seconds);
            }
        }
    }
}
