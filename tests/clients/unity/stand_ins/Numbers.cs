using System;

namespace UnityEngine
{
    /// <summary>Two numbers.</summary>
    public struct Vector2
    {
        /// <summary>First.</summary>
        public float x;

        /// <summary>Second.</summary>
        public float y;

        /// <summary>From both.</summary>
        public Vector2(float x, float y)
        {
            this.x = x;
            this.y = y;
        }

        /// <summary>The origin.</summary>
        public static Vector2 zero
        {
            get { return new Vector2(0, 0); }
        }
    }

    /// <summary>Three numbers, left-handed: x right, y up, z forward.</summary>
    public struct Vector3
    {
        /// <summary>First.</summary>
        public float x;

        /// <summary>Second.</summary>
        public float y;

        /// <summary>Third.</summary>
        public float z;

        /// <summary>From all three.</summary>
        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }

        /// <summary>The origin.</summary>
        public static Vector3 zero
        {
            get { return new Vector3(0, 0, 0); }
        }

        /// <summary>All ones.</summary>
        public static Vector3 one
        {
            get { return new Vector3(1, 1, 1); }
        }

        /// <summary>The sum.</summary>
        public static Vector3 operator +(Vector3 a, Vector3 b)
        {
            return new Vector3(a.x + b.x, a.y + b.y, a.z + b.z);
        }

        /// <summary>The difference.</summary>
        public static Vector3 operator -(Vector3 a, Vector3 b)
        {
            return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z);
        }

        /// <summary>Component by component.</summary>
        public static Vector3 Scale(Vector3 a, Vector3 b)
        {
            return new Vector3(a.x * b.x, a.y * b.y, a.z * b.z);
        }
    }

    /// <summary>A rotation. Unity documents that lhs * rhs turns by rhs in the frame of lhs, and
    /// that rotation * point turns the point.</summary>
    public struct Quaternion
    {
        /// <summary>First component of the axis, times the sine of half the angle.</summary>
        public float x;

        /// <summary>Second.</summary>
        public float y;

        /// <summary>Third.</summary>
        public float z;

        /// <summary>Cosine of half the angle.</summary>
        public float w;

        /// <summary>From its components.</summary>
        public Quaternion(float x, float y, float z, float w)
        {
            this.x = x;
            this.y = y;
            this.z = z;
            this.w = w;
        }

        /// <summary>No rotation.</summary>
        public static Quaternion identity
        {
            get { return new Quaternion(0, 0, 0, 1); }
        }

        /// <summary>Turns about z, x, y, in this order, degrees.</summary>
        public static Quaternion Euler(float x, float y, float z)
        {
            return About(0, 1, 0, y) * About(1, 0, 0, x) * About(0, 0, 1, z);
        }

        /// <summary>The rotation back.</summary>
        public static Quaternion Inverse(Quaternion q)
        {
            return new Quaternion(-q.x, -q.y, -q.z, q.w);
        }

        /// <summary>First b, then a.</summary>
        public static Quaternion operator *(Quaternion a, Quaternion b)
        {
            return new Quaternion(
                a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
                a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x,
                a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
        }

        /// <summary>The point, turned.</summary>
        public static Vector3 operator *(Quaternion q, Vector3 p)
        {
            Quaternion turned = q * new Quaternion(p.x, p.y, p.z, 0) * Inverse(q);
            return new Vector3(turned.x, turned.y, turned.z);
        }

        private static Quaternion About(float x, float y, float z, float degrees)
        {
            double half = degrees * Math.PI / 360;
            float sine = (float)Math.Sin(half);
            return new Quaternion(sine * x, sine * y, sine * z, (float)Math.Cos(half));
        }
    }
}
