using System;
using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>Lists and small arrays of the contract, out of a tree.</summary>
    public static class JsonLists
    {
        /// <summary>An array's items, each made into something.</summary>
        public static List<T> Of<T>(JsonValue array, Func<JsonValue, T> make)
        {
            List<T> result = new List<T>(array.Items.Count);
            foreach (JsonValue item in array.Items)
            {
                result.Add(make(item));
            }
            return result;
        }

        /// <summary>An array of strings.</summary>
        public static List<string> Strings(JsonValue array)
        {
            return Of(array, item => item.AsString());
        }

        /// <summary>An array of strings; empty where there is none.</summary>
        public static List<string> StringsOrNone(JsonValue array)
        {
            return array.Kind == JsonKind.Array ? Strings(array) : new List<string>();
        }

        /// <summary>An array of numbers.</summary>
        /// <exception cref="JsonFormatException">There are not so many.</exception>
        public static double[] Numbers(JsonValue array, int count)
        {
            double[] result = Of(array, item => item.AsDouble()).ToArray();
            if (result.Length != count)
            {
                throw new JsonFormatException(
                    "The answer has " + result.Length + " numbers where " + count + " belong.");
            }
            return result;
        }

        /// <summary>x, y, z.</summary>
        public static Vec3 Vector(JsonValue array)
        {
            double[] v = Numbers(array, 3);
            return new Vec3(v[0], v[1], v[2]);
        }

        /// <summary>x, y, z, w.</summary>
        public static Quat Quaternion(JsonValue array)
        {
            double[] q = Numbers(array, 4);
            return new Quat(q[0], q[1], q[2], q[3]);
        }

        /// <summary>An object with position and orientation.</summary>
        public static RigidPose Pose(JsonValue placed)
        {
            return new RigidPose(Vector(placed["position"]), Quaternion(placed["orientation"]));
        }

        /// <summary>The same, or null.</summary>
        public static RigidPose? PoseOrNull(JsonValue placed)
        {
            return placed.IsNull ? (RigidPose?)null : Pose(placed);
        }
    }
}
