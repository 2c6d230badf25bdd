namespace Snapfit
{
    /// <summary>Where a shown pose comes from.</summary>
    public enum SampleKind
    {
        /// <summary>There is none: do not show the part.</summary>
        None,

        /// <summary>Between two snapshots.</summary>
        Interpolated,

        /// <summary>After the latest snapshot, by its velocities.</summary>
        Predicted,

        /// <summary>Farther after it than velocities can be believed: as far as they can.
        /// </summary>
        Held,
    }

    /// <summary>A part at the time that is shown.</summary>
    public struct PoseSample
    {
        /// <summary>Where it comes from; with <see cref="SampleKind.None"/> there is no pose.
        /// </summary>
        public SampleKind Kind;

        /// <summary>frame_from_body, metres.</summary>
        public RigidPose Pose;

        /// <summary>What the server said of the part in the latest snapshot that counts here.
        /// </summary>
        public PartStatus Status;

        /// <summary>0 to 1: how probably the pose is right.</summary>
        public double Confidence;

        /// <summary>Nothing fresh came: the server said so, or it is silent. Show it differently,
        /// or not at all.</summary>
        public bool IsStale;
    }
}
