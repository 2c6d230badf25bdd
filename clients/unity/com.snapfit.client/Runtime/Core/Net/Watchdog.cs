using System;
using System.Threading;

namespace Snapfit
{
    /// <summary>Calls when nothing was heard for some time, again and again until something is.
    /// </summary>
    internal sealed class Watchdog : IDisposable
    {
        private readonly Action onSilence;
        private readonly long limitUs;
        private readonly Timer timer;
        private long heardUs = MonotonicClock.NowUs;

        public Watchdog(double limitS, Action onSilence)
        {
            this.onSilence = onSilence;
            limitUs = (long)(1e6 * limitS);
            TimeSpan period = TimeSpan.FromSeconds(limitS / 4);
            timer = new Timer(Look, null, period, period);
        }

        public void Heard()
        {
            Interlocked.Exchange(ref heardUs, MonotonicClock.NowUs);
        }

        public void Dispose()
        {
            timer.Dispose();
        }

        private void Look(object state)
        {
            if (MonotonicClock.NowUs - Interlocked.Read(ref heardUs) > limitUs)
            {
                Heard();
                onSilence();
            }
        }
    }
}
