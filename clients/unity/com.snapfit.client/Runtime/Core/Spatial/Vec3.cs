using System;
using System.Globalization;

namespace Snapfit
{
    /// <summary>Three numbers along the axes of some frame; what they are (metres, m/s, rad/s) and
    /// in which frame, the one who holds them says. Double precision.</summary>
    public readonly struct Vec3
    {
        /// <summary>Along the frame's first axis.</summary>
        public readonly double X;

        /// <summary>Along the frame's second axis.</summary>
        public readonly double Y;

        /// <summary>Along the frame's third axis.</summary>
        public readonly double Z;

        /// <summary>From its components.</summary>
        public Vec3(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <summary>The origin.</summary>
        public static Vec3 Zero
        {
            get { return new Vec3(0, 0, 0); }
        }

        /// <summary>Its length, in its own unit.</summary>
        public double Length
        {
            get { return Math.Sqrt(X * X + Y * Y + Z * Z); }
        }

        /// <summary>The sum, component by component.</summary>
        public static Vec3 operator +(Vec3 a, Vec3 b)
        {
            return new Vec3(a.X + b.X, a.Y + b.Y, a.Z + b.Z);
        }

        /// <summary>The difference, component by component.</summary>
        public static Vec3 operator -(Vec3 a, Vec3 b)
        {
            return new Vec3(a.X - b.X, a.Y - b.Y, a.Z - b.Z);
        }

        /// <summary>Scaled.</summary>
        public static Vec3 operator *(double scale, Vec3 v)
        {
            return new Vec3(scale * v.X, scale * v.Y, scale * v.Z);
        }

        /// <summary>The point a share of the way from a (0) to b (1).</summary>
        public static Vec3 Lerp(Vec3 a, Vec3 b, double share)
        {
            return a + share * (b - a);
        }

        /// <summary>For people.</summary>
        public override string ToString()
        {
            return string.Format(CultureInfo.InvariantCulture, "({0:G6}, {1:G6}, {2:G6})", X, Y, Z);
        }
    }
}
