using System.Threading;

namespace Snapfit
{
    /// <summary>Where the transports put what comes: reads it, leaves out what is known already,
    /// hands the rest to the main thread.</summary>
    public sealed class SnapshotInbox
    {
        private readonly SnapshotReader reader = new SnapshotReader();
        private readonly LatestSlot<PoseSnapshot> slot =
            new LatestSlot<PoseSnapshot>(() => new PoseSnapshot());

        private bool lastStale;
        private long received;
        private int restarts;

        /// <summary>The boot_id of the last snapshot; null before the first.</summary>
        public string BootId { get; private set; }

        /// <summary>The seq of the last snapshot.</summary>
        public long Seq { get; private set; }

        /// <summary>How many snapshots came that were new.</summary>
        public long Received
        {
            get { return Volatile.Read(ref received); }
        }

        /// <summary>How often the boot_id became another one: the worker or the server was started
        /// anew, and seq began again.</summary>
        public int Restarts
        {
            get { return Volatile.Read(ref restarts); }
        }

        /// <summary>Takes a snapshot in; called by one transport at a time.</summary>
        /// <returns>Whether it was new.</returns>
        /// <exception cref="JsonFormatException">It is none.</exception>
        public bool Put(byte[] bytes, int count)
        {
            PoseSnapshot snapshot = slot.Back;
            reader.Read(bytes, count, snapshot);
            bool isSameRun = snapshot.BootId == BootId;
            bool isOlder = isSameRun && snapshot.Seq < Seq;
            bool isSame = isSameRun && snapshot.Seq == Seq && snapshot.Stale == lastStale;
            if (isOlder || isSame)
            {
                return false;
            }
            if (BootId != null && !isSameRun)
            {
                Interlocked.Increment(ref restarts);
            }
            BootId = snapshot.BootId;
            Seq = snapshot.Seq;
            lastStale = snapshot.Stale;
            slot.Publish();
            Interlocked.Increment(ref received);
            return true;
        }

        /// <summary>The latest, for the main thread; false where it has that already.</summary>
        public bool TryTake(out PoseSnapshot latest)
        {
            return slot.TryTake(out latest);
        }
    }
}
