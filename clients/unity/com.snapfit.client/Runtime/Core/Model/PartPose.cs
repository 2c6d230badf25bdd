namespace Snapfit
{
    /// <summary>One part in one snapshot, in the snapshot's frame and convention. A snapshot uses
    /// its parts again and again: copy what is to be kept.</summary>
    public sealed class PartPose
    {
        /// <summary>How many numbers a covariance has.</summary>
        public const int CovarianceLength = 36;

        /// <summary>Its name in its asset.</summary>
        public string Part { get; internal set; }

        /// <summary>Where its pose comes from.</summary>
        public PartStatus Status { get; internal set; }

        /// <summary>0 to 1: how probably the pose is right.</summary>
        public double Confidence { get; internal set; }

        /// <summary>Whether it has a pose: a searching or lost part has none.</summary>
        public bool HasPose { get; internal set; }

        /// <summary>frame_from_body, metres; only where it has a pose.</summary>
        public RigidPose Pose { get; internal set; }

        /// <summary>Whether its velocities are known, which needs two frames.</summary>
        public bool HasVelocity { get; internal set; }

        /// <summary>Of the body's origin, m/s, along the frame's axes; zero where unknown.
        /// </summary>
        public Vec3 LinearVelocity { get; internal set; }

        /// <summary>Axis times rate, rad/s, along the frame's axes; zero where unknown.</summary>
        public Vec3 AngularVelocity { get; internal set; }

        /// <summary>Whether its covariance is known.</summary>
        public bool HasCovariance { get; internal set; }

        /// <summary>6x6, row-major, of the right perturbation in the body frame: rotation (rad),
        /// then translation (m). Always the same array; of use only where it is known.</summary>
        public double[] Covariance { get; } = new double[CovarianceLength];

        /// <summary>The part that it is mounted on, or null.</summary>
        public string LinkedTo { get; internal set; }

        /// <summary>Exposure of the last frame that it was tracked in, microseconds of the
        /// server's time; null if it never was.</summary>
        public long? LastSeenAtUs { get; internal set; }

        internal void Clear()
        {
            Part = null;
            Status = PartStatus.Searching;
            Confidence = 0;
            HasPose = HasVelocity = HasCovariance = false;
            Pose = RigidPose.Identity;
            LinearVelocity = AngularVelocity = Vec3.Zero;
            LinkedTo = null;
            LastSeenAtUs = null;
        }
    }
}
