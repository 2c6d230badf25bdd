using System;

namespace Snapfit
{
    /// <summary>Where one part was in the latest snapshots, and where it is at a time in between
    /// or a little after.</summary>
    /// <remarks>Allocates nothing once it is made. One thread alone.</remarks>
    public sealed class PoseTrack
    {
        /// <summary>Velocities are believed for so long, microseconds: 100 ms, as the server's
        /// own.</summary>
        public const long PredictionUs = 100000;

        /// <summary>Farther apart, two snapshots have nothing between them, microseconds.
        /// </summary>
        public const long GapUs = 250000;

        private const int Length = 64;

        private readonly Entry[] entries = new Entry[Length];
        private int newest = -1;
        private int count;

        /// <summary>Forget all.</summary>
        public void Clear()
        {
            newest = -1;
            count = 0;
        }

        /// <summary>What a snapshot says of the part. Older ones than the last are left out.
        /// </summary>
        /// <param name="capturedAtUs">Of the snapshot, server's time.</param>
        /// <param name="part">Is copied.</param>
        public void Add(long capturedAtUs, PartPose part)
        {
            if (count > 0 && capturedAtUs <= entries[newest].AtUs)
            {
                return;
            }
            newest = (newest + 1) % Length;
            count = Math.Min(count + 1, Length);
            entries[newest] = new Entry
            {
                AtUs = capturedAtUs,
                HasPose = part.HasPose,
                Pose = part.Pose,
                Linear = part.LinearVelocity,
                Angular = part.AngularVelocity,
                Status = part.Status,
                Confidence = part.Confidence,
            };
        }

        /// <summary>The part at a time.</summary>
        /// <param name="atUs">Server's time. Before the oldest snapshot that is known it is there
        /// as in that one.</param>
        public PoseSample At(long atUs)
        {
            if (count == 0)
            {
                return default(PoseSample);
            }
            int back = 0;
            while (back < count - 1 && Back(back).AtUs > atUs)
            {
                back++;
            }
            Entry before = Back(back);
            if (!before.HasPose)
            {
                return before.Sample(SampleKind.None, RigidPose.Identity);
            }
            if (back == 0 || before.AtUs >= atUs)
            {
                return Ahead(before, Math.Max(0, atUs - before.AtUs));
            }
            Entry after = Back(back - 1);
            long spanUs = after.AtUs - before.AtUs;
            if (!after.HasPose || spanUs > GapUs)
            {
                return Ahead(before, atUs - before.AtUs);
            }
            double share = (double)(atUs - before.AtUs) / spanUs;
            RigidPose between = RigidPose.Between(before.Pose, after.Pose, share);
            return (share < 0.5 ? before : after).Sample(SampleKind.Interpolated, between);
        }

        private static PoseSample Ahead(Entry entry, long aheadUs)
        {
            double aheadS = 1e-6 * Math.Min(aheadUs, PredictionUs);
            RigidPose moved = entry.Pose.Moved(entry.Linear, entry.Angular, aheadS);
            SampleKind kind = aheadUs > PredictionUs ? SampleKind.Held
                : aheadUs > 0 ? SampleKind.Predicted : SampleKind.Interpolated;
            return entry.Sample(kind, moved);
        }

        private Entry Back(int steps)
        {
            return entries[(newest - steps + Length) % Length];
        }

        private struct Entry
        {
            public long AtUs;
            public bool HasPose;
            public RigidPose Pose;
            public Vec3 Linear;
            public Vec3 Angular;
            public PartStatus Status;
            public double Confidence;

            public PoseSample Sample(SampleKind kind, RigidPose pose)
            {
                return new PoseSample
                {
                    Kind = kind,
                    Pose = pose,
                    Status = Status,
                    Confidence = Confidence,
                };
            }
        }
    }
}
