using UnityEngine;

namespace Snapfit.Unity
{
    /// <summary>Between the core's numbers (double, metres) and Unity's (single, Unity units, which
    /// are metres). Poses here are in the convention unity: x right, y up, z forward.</summary>
    public static class UnitySpace
    {
        /// <summary>The local rotation of a mesh that a glTF importer (glTFast, UnityGLTF) has
        /// made, below the object that gets the part's pose: half a turn about y, because
        /// importers negate x and the convention unity negates z.</summary>
        public static readonly Quaternion GltfRotation = new Quaternion(0, 1, 0, 0);

        /// <summary>A vector of the core, as Unity's.</summary>
        public static Vector3 ToUnity(this Vec3 v)
        {
            return new Vector3((float)v.X, (float)v.Y, (float)v.Z);
        }

        /// <summary>A rotation of the core, as Unity's.</summary>
        public static Quaternion ToUnity(this Quat q)
        {
            return new Quaternion((float)q.X, (float)q.Y, (float)q.Z, (float)q.W);
        }

        /// <summary>A pose of Unity, as the core's.</summary>
        public static RigidPose ToPose(Vector3 position, Quaternion rotation)
        {
            return new RigidPose(
                new Vec3(position.x, position.y, position.z),
                new Quat(rotation.x, rotation.y, rotation.z, rotation.w).Normalised);
        }

        /// <summary>Puts an object where a pose says.</summary>
        /// <param name="target">Its scale stays.</param>
        /// <param name="pose">In the frame of the origin, metres.</param>
        /// <param name="origin">Null for Unity's world. Its scale counts.</param>
        public static void Place(Transform target, RigidPose pose, Transform origin)
        {
            Vector3 position = pose.Position.ToUnity();
            Quaternion rotation = pose.Orientation.ToUnity();
            if (origin != null)
            {
                position = origin.TransformPoint(position);
                rotation = origin.rotation * rotation;
            }
            target.SetPositionAndRotation(position, rotation);
        }
    }
}
