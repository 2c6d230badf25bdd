namespace Snapfit
{
    /// <summary>A pose a_from_b: maps points of frame b (metres) into frame a.</summary>
    public readonly struct RigidPose
    {
        /// <summary>Where the origin of b is, in a, metres.</summary>
        public readonly Vec3 Position;

        /// <summary>How the axes of b are turned, in a.</summary>
        public readonly Quat Orientation;

        /// <summary>From its two halves.</summary>
        public RigidPose(Vec3 position, Quat orientation)
        {
            Position = position;
            Orientation = orientation;
        }

        /// <summary>Frames that coincide.</summary>
        public static RigidPose Identity
        {
            get { return new RigidPose(Vec3.Zero, Quat.Identity); }
        }

        /// <summary>b_from_a.</summary>
        public RigidPose Inverse
        {
            get
            {
                Quat back = Orientation.Inverse;
                return new RigidPose(back.Rotate(-1 * Position), back);
            }
        }

        /// <summary>a_from_c = a_from_b * b_from_c.</summary>
        public static RigidPose operator *(RigidPose a, RigidPose b)
        {
            return new RigidPose(a.Apply(b.Position), (a.Orientation * b.Orientation).Normalised);
        }

        /// <summary>A point of b (metres), in a.</summary>
        public Vec3 Apply(Vec3 point)
        {
            return Orientation.Rotate(point) + Position;
        }

        /// <summary>Where the body is some time later, by velocities along the axes of a.</summary>
        /// <param name="linear">Of the body's origin, m/s.</param>
        /// <param name="angular">Axis times rate, rad/s.</param>
        /// <param name="aheadS">Seconds; backwards if negative.</param>
        public RigidPose Moved(Vec3 linear, Vec3 angular, double aheadS)
        {
            // The axis is given in a: the turn acts on the left.
            Quat turned = Quat.Exp(aheadS * angular) * Orientation;
            return new RigidPose(Position + aheadS * linear, turned.Normalised);
        }

        /// <summary>The pose a share of the way from a (0) to b (1).</summary>
        public static RigidPose Between(RigidPose a, RigidPose b, double share)
        {
            return new RigidPose(
                Vec3.Lerp(a.Position, b.Position, share),
                Quat.Slerp(a.Orientation, b.Orientation, share));
        }
    }
}
