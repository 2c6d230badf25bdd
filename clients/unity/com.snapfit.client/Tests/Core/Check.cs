using System;

namespace Snapfit.Tests
{
    /// <summary>Assertions that need no test framework, so that the same tests run in Unity's
    /// Test Runner and by themselves.</summary>
    public static class Check
    {
        /// <summary>It holds.</summary>
        public static void That(bool holds, string what)
        {
            if (!holds)
            {
                throw new Exception("Does not hold: " + what);
            }
        }

        /// <summary>They are equal.</summary>
        public static void Equal<T>(T expected, T actual, string what = "value")
        {
            That(Equals(expected, actual), what + ": expected " + expected + ", got " + actual);
        }

        /// <summary>They are as near as that.</summary>
        public static void Near(double expected, double actual, double tolerance, string what)
        {
            bool isNear = Math.Abs(expected - actual) <= tolerance;
            That(isNear, what + ": expected " + expected + ", got " + actual);
        }

        /// <summary>They are as near as that, in each component.</summary>
        public static void Near(Vec3 expected, Vec3 actual, double tolerance, string what)
        {
            bool isNear = (expected - actual).Length <= tolerance;
            That(isNear, what + ": expected " + expected + ", got " + actual);
        }

        /// <summary>They are the same rotation, as near as that (radians).</summary>
        public static void Near(Quat expected, Quat actual, double tolerance, string what)
        {
            bool isNear = Quat.Angle(expected, actual) <= tolerance;
            That(isNear, what + ": expected " + expected + ", got " + actual);
        }

        /// <summary>It throws, and the message has a text in it.</summary>
        public static void Throws<T>(Action action, string message)
            where T : Exception
        {
            try
            {
                action();
            }
            catch (T error)
            {
                That(error.Message.Contains(message), "'" + message + "' in: " + error.Message);
                return;
            }
            throw new Exception("Nothing was thrown where " + typeof(T).Name + " belongs");
        }
    }
}
