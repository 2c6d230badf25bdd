using System.Collections.Generic;
using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Tests
{
    /// <summary>Objects for tests of the layer.</summary>
    public static class Scene
    {
        /// <summary>The golden vectors along Unity's axes.</summary>
        public static IEnumerable<JsonValue> GoldenUnity(string frame)
        {
            foreach (JsonValue each in ConventionTests.Golden()["cases"].Items)
            {
                yield return each[frame]["unity"];
            }
        }

        /// <summary>A part's object with a mesh below it, running.</summary>
        public static PoseDriver Driver()
        {
            PoseDriver driver = new GameObject("part").AddComponent<PoseDriver>();
            driver.Visual = new GameObject("mesh");
            driver.Visual.transform.parent = driver.transform;
            Engine.Enable(driver);
            return driver;
        }

        /// <summary>A fresh sample.</summary>
        public static PoseSample Sample(RigidPose pose)
        {
            return new PoseSample
            {
                Kind = SampleKind.Interpolated,
                Pose = pose,
                Status = PartStatus.Tracked,
                Confidence = 0.9,
            };
        }

        /// <summary>A point is where a golden one is, metres.</summary>
        public static void Near(JsonValue golden, Vector3 actual, double tolerance)
        {
            Check.Near(
                JsonLists.Vector(golden), new Vec3(actual.x, actual.y, actual.z), tolerance,
                "point");
        }
    }
}
