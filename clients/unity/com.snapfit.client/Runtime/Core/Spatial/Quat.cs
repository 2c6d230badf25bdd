using System;
using System.Globalization;

namespace Snapfit
{
    /// <summary>A rotation as a unit quaternion, in the order x, y, z, w. Its negative is the same
    /// rotation. The algebra is Hamilton's, which holds in left-handed frames too.</summary>
    public readonly struct Quat
    {
        /// <summary>First component of the axis, times the sine of half the angle.</summary>
        public readonly double X;

        /// <summary>Second component of the axis, times the sine of half the angle.</summary>
        public readonly double Y;

        /// <summary>Third component of the axis, times the sine of half the angle.</summary>
        public readonly double Z;

        /// <summary>Cosine of half the angle.</summary>
        public readonly double W;

        // Below this the ends of a slerp are as good as parallel.
        private const double NearlyOne = 1 - 1e-9;

        /// <summary>From its components, which are taken as they are.</summary>
        public Quat(double x, double y, double z, double w)
        {
            X = x;
            Y = y;
            Z = z;
            W = w;
        }

        /// <summary>No rotation.</summary>
        public static Quat Identity
        {
            get { return new Quat(0, 0, 0, 1); }
        }

        /// <summary>The rotation back, of a unit quaternion.</summary>
        public Quat Inverse
        {
            get { return new Quat(-X, -Y, -Z, W); }
        }

        /// <summary>The same rotation with length 1.</summary>
        public Quat Normalised
        {
            get
            {
                double length = Math.Sqrt(Dot(this, this));
                return new Quat(X / length, Y / length, Z / length, W / length);
            }
        }

        /// <summary>First b, then a: a_from_c = a_from_b * b_from_c.</summary>
        public static Quat operator *(Quat a, Quat b)
        {
            return new Quat(
                a.W * b.X + a.X * b.W + a.Y * b.Z - a.Z * b.Y,
                a.W * b.Y - a.X * b.Z + a.Y * b.W + a.Z * b.X,
                a.W * b.Z + a.X * b.Y - a.Y * b.X + a.Z * b.W,
                a.W * b.W - a.X * b.X - a.Y * b.Y - a.Z * b.Z);
        }

        /// <summary>The vector, turned.</summary>
        public Vec3 Rotate(Vec3 v)
        {
            // v + 2 w (u x v) + 2 u x (u x v), with u the vector part.
            double tx = 2 * (Y * v.Z - Z * v.Y);
            double ty = 2 * (Z * v.X - X * v.Z);
            double tz = 2 * (X * v.Y - Y * v.X);
            return new Vec3(
                v.X + W * tx + Y * tz - Z * ty,
                v.Y + W * ty + Z * tx - X * tz,
                v.Z + W * tz + X * ty - Y * tx);
        }

        /// <summary>The four-dimensional scalar product.</summary>
        public static double Dot(Quat a, Quat b)
        {
            return a.X * b.X + a.Y * b.Y + a.Z * b.Z + a.W * b.W;
        }

        /// <summary>The angle between two rotations, 0 to pi, radians.</summary>
        public static double Angle(Quat a, Quat b)
        {
            // By the sine too: the cosine alone is blind to small angles.
            Quat apart = a.Inverse * b;
            double sine = Math.Sqrt(apart.X * apart.X + apart.Y * apart.Y + apart.Z * apart.Z);
            return 2 * Math.Atan2(sine, Math.Abs(apart.W));
        }

        /// <summary>The rotation by a vector's length (radians) about its direction.</summary>
        public static Quat Exp(Vec3 rotation)
        {
            double angle = rotation.Length;
            // sin(angle / 2) / angle, by its Taylor series near zero.
            double scale = angle < 1e-4 ? 0.5 - angle * angle / 48 : Math.Sin(angle / 2) / angle;
            return new Quat(
                scale * rotation.X, scale * rotation.Y, scale * rotation.Z, Math.Cos(angle / 2));
        }

        /// <summary>The rotation a share of the shorter way from a (0) to b (1), at a constant
        /// rate.</summary>
        public static Quat Slerp(Quat a, Quat b, double share)
        {
            double cosine = Dot(a, b);
            double sign = cosine < 0 ? -1 : 1;
            cosine = Math.Abs(cosine);
            double ofA = 1 - share;
            double ofB = share;
            if (cosine < NearlyOne)
            {
                double angle = Math.Acos(cosine);
                ofA = Math.Sin((1 - share) * angle) / Math.Sin(angle);
                ofB = Math.Sin(share * angle) / Math.Sin(angle);
            }
            ofB *= sign;
            return new Quat(
                ofA * a.X + ofB * b.X, ofA * a.Y + ofB * b.Y, ofA * a.Z + ofB * b.Z,
                ofA * a.W + ofB * b.W).Normalised;
        }

        /// <summary>For people.</summary>
        public override string ToString()
        {
            return string.Format(
                CultureInfo.InvariantCulture, "({0:G6}, {1:G6}, {2:G6}, {3:G6})", X, Y, Z, W);
        }
    }
}
