using System;
using System.Text;
using System.Threading;

namespace Snapfit.Tests
{
    /// <summary>From the network's thread to the main thread: the latest wins.</summary>
    public static class HandOverTests
    {
        /// <summary>What was not taken is overwritten; what was is not given twice.</summary>
        public static void TheLatestWins()
        {
            LatestSlot<int[]> slot = new LatestSlot<int[]>(() => new int[1]);
            int[] taken;
            Check.That(!slot.TryTake(out taken), "nothing yet");
            for (int number = 1; number <= 5; number++)
            {
                slot.Back[0] = number;
                slot.Publish();
            }
            Check.That(slot.TryTake(out taken) && taken[0] == 5, "the latest");
            Check.That(!slot.TryTake(out taken) && taken[0] == 5, "not twice");
            slot.Back[0] = 6;
            slot.Publish();
            Check.Equal(5, taken[0], "untouched while it is held");
        }

        /// <summary>Two threads at full speed: never half of one and half of another.</summary>
        public static void ThreadsDoNotMixSnapshots()
        {
            LatestSlot<int[]> slot = new LatestSlot<int[]>(() => new int[64]);
            const int Last = 200000;
            Thread writer = new Thread(() =>
            {
                for (int number = 1; number <= Last; number++)
                {
                    int[] back = slot.Back;
                    for (int place = 0; place < back.Length; place++)
                    {
                        back[place] = number;
                    }
                    slot.Publish();
                }
            });
            writer.Start();
            int seen = 0;
            while (seen < Last)
            {
                int[] latest;
                if (slot.TryTake(out latest))
                {
                    int number = latest[0];
                    Check.That(number > seen, "forwards");
                    Check.That(Array.TrueForAll(latest, it => it == number), "of one piece");
                    seen = number;
                }
            }
            writer.Join();
        }

        /// <summary>Known and older snapshots are left out; a change of stale is not.</summary>
        public static void TheInboxTakesWhatIsNew()
        {
            SnapshotInbox inbox = new SnapshotInbox();
            Check.That(Put(inbox, "a", 7, false), "first");
            Check.That(!Put(inbox, "a", 7, false), "the same");
            Check.That(!Put(inbox, "a", 6, false), "older");
            Check.That(Put(inbox, "a", 7, true), "stale now");
            Check.That(Put(inbox, "a", 8, false), "newer");
            Check.Equal(3L, inbox.Received, "received");
            Check.Equal(0, inbox.Restarts, "restarts");
        }

        /// <summary>With another boot_id, seq begins again.</summary>
        public static void ARestartResetsTheSequence()
        {
            SnapshotInbox inbox = new SnapshotInbox();
            Put(inbox, "a", 5000, false);
            Check.That(Put(inbox, "b", 1, false), "another run");
            Check.Equal(1, inbox.Restarts, "restarts");
            Check.That(Put(inbox, "b", 2, false), "goes on");
            PoseSnapshot latest;
            Check.That(inbox.TryTake(out latest) && latest.BootId == "b", "handed over");
            Check.Equal(2L, latest.Seq);
        }

        /// <summary>A broken answer leaves the last one as it was.</summary>
        public static void ABrokenAnswerChangesNothing()
        {
            SnapshotInbox inbox = new SnapshotInbox();
            Put(inbox, "a", 1, false);
            byte[] half = Encoding.UTF8.GetBytes("{\"boot_id\":\"a\",\"seq\":2,\"frame\":\"came");
            Check.Throws<JsonFormatException>(() => inbox.Put(half, half.Length), "string");
            PoseSnapshot latest;
            Check.That(inbox.TryTake(out latest) && latest.Seq == 1, "the one before");
        }

        private static bool Put(SnapshotInbox inbox, string boot, long seq, bool stale)
        {
            byte[] bytes = Encoding.UTF8.GetBytes("{\"boot_id\":\"" + boot + "\",\"seq\":" + seq
                + ",\"frame\":\"camera\",\"stale\":" + (stale ? "true" : "false") + "}");
            return inbox.Put(bytes, bytes.Length);
        }
    }
}
