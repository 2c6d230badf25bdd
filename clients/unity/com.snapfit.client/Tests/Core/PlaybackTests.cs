using System;

namespace Snapfit.Tests
{
    /// <summary>What is shown between snapshots, after the latest, and when none come.</summary>
    public static class PlaybackTests
    {
        private const long T0 = 1795366685000000;
        private const long FrameUs = 33333;
        private static readonly Vec3 Slow = new Vec3(0.3, 0, 0);

        /// <summary>Between two snapshots: on the straight way.</summary>
        public static void InterpolatesBetweenSnapshots()
        {
            PosePlayer player = Player(100000);
            Add(player, "a", 1, 0, new Vec3(0, 0, 1));
            Add(player, "a", 2, FrameUs, new Vec3(0.01, 0, 1));
            PoseSample sample = player.Sample("jaw", T0 + 100000 + FrameUs / 4);
            Check.Equal(SampleKind.Interpolated, sample.Kind);
            Check.Near(new Vec3(0.0025, 0, 1), sample.Pose.Position, 1e-6, "a quarter");
            Check.That(!sample.IsStale, "fresh");
            Check.Near(0.9, sample.Confidence, 0, "confidence");
        }

        /// <summary>After the latest: by its velocities, turning and moving.</summary>
        public static void PredictsByVelocities()
        {
            PosePlayer player = Player(0);
            player.Add(Samples.Of(
                "a", 1, T0, false, new Vec3(0, 0, 1), Slow, new Vec3(0, 0, Math.PI)));
            PoseSample sample = player.Sample("jaw", T0 + 50000);
            Check.Equal(SampleKind.Predicted, sample.Kind);
            Check.Near(new Vec3(0.015, 0, 1), sample.Pose.Position, 1e-9, "position");
            Check.Near(Quat.Exp(new Vec3(0, 0, 0.05 * Math.PI)), sample.Pose.Orientation, 1e-9,
                "orientation");
        }

        /// <summary>Not farther than 100 ms; then it stays there, and is stale after half a
        /// second.</summary>
        public static void BelievesVelocitiesForATenthOfASecond()
        {
            PosePlayer player = Player(0);
            player.Add(Samples.Of("a", 1, T0, false, new Vec3(0, 0, 1), Slow, Vec3.Zero));
            PoseSample sample = player.Sample("jaw", T0 + 400000);
            Check.Equal(SampleKind.Held, sample.Kind);
            Check.Near(new Vec3(0.03, 0, 1), sample.Pose.Position, 1e-9, "held");
            Check.That(!sample.IsStale, "not yet");
            Check.That(player.Sample("jaw", T0 + 500001).IsStale, "stale by silence");
        }

        /// <summary>The server's own word counts at once.</summary>
        public static void TheServerSaysStale()
        {
            PosePlayer player = Player(0);
            player.Add(Samples.Of("a", 1, T0, true, new Vec3(0, 0, 1), Vec3.Zero, Vec3.Zero));
            Check.That(player.Sample("jaw", T0 + 1000).IsStale, "stale");
            player.Add(Samples.Of("a", 1, T0, false, new Vec3(0, 0, 1), Vec3.Zero, Vec3.Zero));
            Check.That(!player.Sample("jaw", T0 + 1000).IsStale, "fresh again");
        }

        /// <summary>A lost part is not shown from the moment on that it was lost.</summary>
        public static void ALostPartIsNotShown()
        {
            PosePlayer player = Player(100000);
            Add(player, "a", 1, 0, new Vec3(0, 0, 1));
            player.Add(Samples.Of("a", 2, T0 + FrameUs, false, null, Vec3.Zero, Vec3.Zero));
            PoseSample before = player.Sample("jaw", T0 + 100000 + FrameUs / 2);
            Check.Equal(SampleKind.Predicted, before.Kind, "before");
            PoseSample after = player.Sample("jaw", T0 + 100000 + FrameUs);
            Check.Equal(SampleKind.None, after.Kind, "after");
            Check.Equal(PartStatus.Lost, after.Status);
            Add(player, "a", 3, 2 * FrameUs, new Vec3(1, 0, 1));
            PoseSample between = player.Sample("jaw", T0 + 100000 + 3 * FrameUs / 2);
            Check.Equal(SampleKind.None, between.Kind, "nothing between lost and found");
            PoseSample found = player.Sample("jaw", T0 + 100000 + 2 * FrameUs);
            Check.Near(new Vec3(1, 0, 1), found.Pose.Position, 1e-9, "found");
        }

        /// <summary>Over a gap nothing is invented.</summary>
        public static void AGapIsNotFilled()
        {
            PosePlayer player = Player(0);
            Add(player, "a", 1, 0, new Vec3(0, 0, 1));
            Add(player, "a", 2, 300000, new Vec3(5, 0, 1));
            PoseSample sample = player.Sample("jaw", T0 + 200000);
            Check.Equal(SampleKind.Held, sample.Kind);
            Check.Near(new Vec3(0, 0, 1), sample.Pose.Position, 1e-9, "as before the gap");
        }

        /// <summary>Another run of the worker begins anew, also with an earlier clock.</summary>
        public static void AnotherRunBeginsAnew()
        {
            PosePlayer player = Player(0);
            Add(player, "a", 900, 0, new Vec3(0, 0, 1));
            Add(player, "b", 1, -5000000, new Vec3(2, 0, 1));
            PoseSample sample = player.Sample("jaw", T0 - 5000000);
            Check.Near(new Vec3(2, 0, 1), sample.Pose.Position, 1e-9, "of the new run");
        }

        /// <summary>A snapshot that comes too late changes nothing.</summary>
        public static void OlderSnapshotsAreLeftOut()
        {
            PosePlayer player = Player(0);
            Add(player, "a", 2, FrameUs, new Vec3(1, 0, 1));
            Add(player, "a", 1, 0, new Vec3(0, 0, 1));
            PoseSample sample = player.Sample("jaw", T0 + FrameUs);
            Check.Near(new Vec3(1, 0, 1), sample.Pose.Position, 1e-9, "the newer");
        }

        /// <summary>Parts that never came are not shown.</summary>
        public static void UnknownPartsAreNotShown()
        {
            PosePlayer player = Player(0);
            Add(player, "a", 1, 0, new Vec3(0, 0, 1));
            Check.Equal(SampleKind.None, player.Sample("cap", T0).Kind);
            Check.Equal(SampleKind.None, player.Sample(null, T0).Kind);
            Check.That(Player(0).Sample("jaw", T0).IsStale, "nothing came at all");
        }

        /// <summary>Long runs: the ring of the last snapshots goes round.</summary>
        public static void TheRingGoesRound()
        {
            PosePlayer player = Player(100000);
            for (int seq = 1; seq <= 1000; seq++)
            {
                Add(player, "a", seq, seq * FrameUs, new Vec3(0.001 * seq, 0, 1));
            }
            long shownUs = T0 + 998 * FrameUs + FrameUs / 2;
            PoseSample sample = player.Sample("jaw", shownUs + 100000);
            Check.Near(new Vec3(0.9985, 0, 1), sample.Pose.Position, 1e-7, "interpolated");
            PoseSample oldest = player.Sample("jaw", T0);
            Check.Near(new Vec3(0.937, 0, 1), oldest.Pose.Position, 1e-9, "the oldest kept");
        }

        private static PosePlayer Player(long delayUs)
        {
            return new PosePlayer { PlayoutDelayUs = delayUs };
        }

        private static void Add(PosePlayer player, string boot, long seq, long atUs, Vec3 position)
        {
            player.Add(Samples.Of(
                boot, seq, T0 + atUs, false, position, Vec3.Zero, Vec3.Zero));
        }
    }
}
