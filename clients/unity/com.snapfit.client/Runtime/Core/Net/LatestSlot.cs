using System;
using System.Threading;

namespace Snapfit
{
    /// <summary>Hands the latest of something from one thread to another: three objects go round,
    /// nobody waits, nothing is allocated, and what was not taken is overwritten.</summary>
    /// <typeparam name="T">What is filled again and again.</typeparam>
    public sealed class LatestSlot<T>
        where T : class
    {
        private const int Fresh = 4;

        private readonly T[] items = new T[3];
        private int back;
        private int front = 2;
        private int between = 1;

        /// <summary>With three objects of the maker's.</summary>
        public LatestSlot(Func<T> make)
        {
            for (int place = 0; place < items.Length; place++)
            {
                items[place] = make();
            }
        }

        /// <summary>What the writing thread fills; another one after each
        /// <see cref="Publish"/>.</summary>
        public T Back
        {
            get { return items[back]; }
        }

        /// <summary>The writing thread is done with <see cref="Back"/>.</summary>
        public void Publish()
        {
            back = Interlocked.Exchange(ref between, back | Fresh) & ~Fresh;
        }

        /// <summary>The latest, for the reading thread; false where it has that already. What is
        /// taken stays untouched until the next one is.</summary>
        public bool TryTake(out T latest)
        {
            bool isFresh = (Volatile.Read(ref between) & Fresh) != 0;
            if (isFresh)
            {
                front = Interlocked.Exchange(ref between, front) & ~Fresh;
            }
            latest = items[front];
            return isFresh;
        }
    }
}
