using System;

namespace Snapfit.Tests
{
    /// <summary>Rotations and poses by their properties.</summary>
    public static class SpatialTests
    {
        private const double Tiny = 1e-12;

        /// <summary>Turning one after the other is turning by the product.</summary>
        public static void ProductsAreCompositions()
        {
            Random random = new Random(1);
            for (int turn = 0; turn < 200; turn++)
            {
                RigidPose a = AnyPose(random);
                RigidPose b = AnyPose(random);
                Vec3 point = AnyVector(random);
                Check.Near(a.Apply(b.Apply(point)), (a * b).Apply(point), Tiny, "product");
                Check.Near(point, a.Inverse.Apply(a.Apply(point)), Tiny, "inverse");
                Check.Near(
                    point.Length, a.Orientation.Rotate(point).Length, Tiny, "length");
            }
        }

        /// <summary>Known answers: a quarter turn about z brings x to y.</summary>
        public static void ExpKnowsAQuarterTurn()
        {
            Quat quarter = Quat.Exp(new Vec3(0, 0, Math.PI / 2));
            Check.Near(new Vec3(0, 1, 0), quarter.Rotate(new Vec3(1, 0, 0)), Tiny, "x to y");
            Check.Near(Math.PI / 2, Quat.Angle(Quat.Identity, quarter), Tiny, "angle");
            Check.Near(1e-9, Quat.Angle(Quat.Identity, Quat.Exp(new Vec3(1e-9, 0, 0))), 1e-18,
                "small angle");
            foreach (double angle in new[] { 0.99e-4, 1.01e-4 })
            {
                double sine = Quat.Exp(new Vec3(angle, 0, 0)).X;
                Check.Near(Math.Sin(angle / 2), sine, 1e-19, "both branches");
            }
        }

        /// <summary>Slerp: ends, constant rate, the shorter way.</summary>
        public static void SlerpTurnsAtAConstantRate()
        {
            Random random = new Random(2);
            for (int turn = 0; turn < 200; turn++)
            {
                Quat a = AnyPose(random).Orientation;
                Quat b = AnyPose(random).Orientation;
                double angle = Quat.Angle(a, b);
                Check.Near(a, Quat.Slerp(a, b, 0), 1e-9, "begin");
                Check.Near(b, Quat.Slerp(a, b, 1), 1e-9, "end");
                double share = random.NextDouble();
                Quat between = Quat.Slerp(a, b, share);
                Check.Near(share * angle, Quat.Angle(a, between), 1e-9, "from the begin");
                Check.Near((1 - share) * angle, Quat.Angle(between, b), 1e-9, "to the end");
                Quat negative = new Quat(-b.X, -b.Y, -b.Z, -b.W);
                Check.Near(between, Quat.Slerp(a, negative, share), 1e-9, "the same rotation");
            }
        }

        /// <summary>Slerp of rotations that are all but equal is neither NaN nor off.</summary>
        public static void SlerpOfNearlyEqualRotations()
        {
            Quat a = Quat.Exp(new Vec3(0.3, 0.2, 0.1));
            Check.Near(a, Quat.Slerp(a, a, 0.3), Tiny, "equal");
            Quat b = Quat.Exp(new Vec3(1e-6, 0, 0)) * a;
            Check.Near(0.25e-6, Quat.Angle(a, Quat.Slerp(a, b, 0.25)), 1e-12, "nearly equal");
        }

        /// <summary>Velocities are along the frame's axes: a body turning about the frame's z while
        /// it moves.</summary>
        public static void MovedGoesAlongTheFramesAxes()
        {
            RigidPose start = new RigidPose(
                new Vec3(1, 0, 0), Quat.Exp(new Vec3(Math.PI / 2, 0, 0)));
            RigidPose moved = start.Moved(new Vec3(0, 2, 0), new Vec3(0, 0, Math.PI), 0.5);
            Check.Near(new Vec3(1, 1, 0), moved.Position, Tiny, "position");
            // The body's y was along the frame's z, which the turn about z leaves alone.
            Vec3 y = moved.Orientation.Rotate(new Vec3(0, 1, 0));
            Check.Near(new Vec3(0, 0, 1), y, Tiny, "body's y");
            Vec3 x = moved.Orientation.Rotate(new Vec3(1, 0, 0));
            Check.Near(new Vec3(0, 1, 0), x, Tiny, "body's x");
            RigidPose back = moved.Moved(new Vec3(0, 2, 0), new Vec3(0, 0, Math.PI), -0.5);
            Check.Near(start.Position, back.Position, Tiny, "back");
            Check.Near(start.Orientation, back.Orientation, 1e-9, "turned back");
        }

        private static RigidPose AnyPose(Random random)
        {
            return new RigidPose(AnyVector(random), Quat.Exp(1.7 * AnyVector(random)));
        }

        private static Vec3 AnyVector(Random random)
        {
            return new Vec3(
                2 * random.NextDouble() - 1, 2 * random.NextDouble() - 1,
                2 * random.NextDouble() - 1);
        }
    }
}
