using System;

namespace Snapfit
{
    /// <summary>Converts from one convention into another one. Every frame goes through the same
    /// matrix B, the camera's, a part's own, an anchor's, so that products of poses cancel.
    /// </summary>
    /// <remarks>docs/conventions.md of snapfit has the table: positions B v, poses B R B^T,
    /// quaternions and angular velocities det(B) B, covariances T C T^T with
    /// T = diag(det(B) B, B).</remarks>
    public sealed class ConventionMap
    {
        private const int Axes = 3;
        private const int Variations = 6;

        // Rows of convention_from_opencv, in the order of the enumeration.
        private static readonly double[][] FromOpenCv =
        {
            new double[] { 1, 0, 0, 0, 1, 0, 0, 0, 1 },
            new double[] { 1, 0, 0, 0, -1, 0, 0, 0, -1 },
            new double[] { 1, 0, 0, 0, -1, 0, 0, 0, 1 },
            new double[] { 0, 0, 1, -1, 0, 0, 0, -1, 0 },
            new double[] { 1, 0, 0, 0, 1, 0, 0, 0, 1 },
        };

        private readonly double[] b = new double[Axes * Axes];
        private readonly double sense;

        /// <summary>The map from one convention to another.</summary>
        public ConventionMap(Convention from, Convention to)
        {
            double[] target = FromOpenCv[(int)to];
            double[] source = FromOpenCv[(int)from];
            for (int row = 0; row < Axes; row++)
            {
                for (int column = 0; column < Axes; column++)
                {
                    for (int k = 0; k < Axes; k++)
                    {
                        b[Axes * row + column] +=
                            target[Axes * row + k] * source[Axes * column + k];
                    }
                }
            }
            sense = b[0] * (b[4] * b[8] - b[5] * b[7]) - b[1] * (b[3] * b[8] - b[5] * b[6])
                + b[2] * (b[3] * b[7] - b[4] * b[6]);
        }

        /// <summary>A position, a mesh vertex, an anchor, a linear velocity.</summary>
        public Vec3 Vector(Vec3 v)
        {
            return new Vec3(
                b[0] * v.X + b[1] * v.Y + b[2] * v.Z,
                b[3] * v.X + b[4] * v.Y + b[5] * v.Z,
                b[6] * v.X + b[7] * v.Y + b[8] * v.Z);
        }

        /// <summary>An angular velocity: a mirror turns the sense of a rotation round.</summary>
        public Vec3 Turn(Vec3 v)
        {
            return sense * Vector(v);
        }

        /// <summary>An orientation.</summary>
        public Quat Orientation(Quat q)
        {
            Vec3 axis = Turn(new Vec3(q.X, q.Y, q.Z));
            return new Quat(axis.X, axis.Y, axis.Z, q.W);
        }

        /// <summary>A pose.</summary>
        public RigidPose Pose(RigidPose pose)
        {
            return new RigidPose(Vector(pose.Position), Orientation(pose.Orientation));
        }

        /// <summary>A covariance: 36 numbers, row-major, rotation before translation.</summary>
        /// <exception cref="ArgumentException">It has not 36 numbers.</exception>
        public void Covariance(double[] from, double[] to)
        {
            if (from.Length != Variations * Variations || to.Length != Variations * Variations)
            {
                throw new ArgumentException("A covariance has 36 numbers.");
            }
            for (int row = 0; row < Variations; row++)
            {
                for (int column = 0; column < Variations; column++)
                {
                    to[Variations * row + column] = Entry(from, row, column);
                }
            }
        }

        private double Entry(double[] from, int row, int column)
        {
            double sum = 0;
            int rowBlock = Axes * (row / Axes);
            int columnBlock = Axes * (column / Axes);
            for (int i = 0; i < Axes; i++)
            {
                for (int j = 0; j < Axes; j++)
                {
                    sum += b[Axes * (row % Axes) + i] * b[Axes * (column % Axes) + j]
                        * from[Variations * (rowBlock + i) + columnBlock + j];
                }
            }
            // det(B) counts once for each index of a rotation; twice is one.
            return rowBlock == columnBlock ? sum : sense * sum;
        }
    }
}
