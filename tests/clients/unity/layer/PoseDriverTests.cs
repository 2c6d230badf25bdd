using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Tests
{
    /// <summary>A part's object is where the golden vectors say, meshes and all.</summary>
    public static class PoseDriverTests
    {
        private const double Single = 2e-6;

        /// <summary>Position, orientation, and the golden vertex of the mesh.</summary>
        public static void PutsTheObjectWhereTheGoldenPoseIs()
        {
            int compared = 0;
            foreach (JsonValue golden in Scene.GoldenUnity("camera"))
            {
                PoseDriver driver = Scene.Driver();
                driver.Apply(Scene.Sample(JsonLists.Pose(golden)), null);
                Vector3 there = driver.transform.TransformPoint(
                    JsonLists.Vector(golden["vertex_in_body"]).ToUnity());
                Scene.Near(golden["vertex_in_frame"], there, Single);
                Scene.Near(golden["position"], driver.transform.position, Single);
                compared++;
            }
            Check.Equal(8, compared, "golden poses");
        }

        /// <summary>A glTF mesh below it: importers negate x of what is in the file, and the
        /// child's half turn about y puts that right.</summary>
        public static void AnImportedGltfMeshFits()
        {
            Vec3 inFile = JsonLists.Vector(ConventionTests.Golden()["gltf"]["vertex_in_body"]);
            Vector3 imported = new Vec3(-inFile.X, inFile.Y, inFile.Z).ToUnity();
            foreach (JsonValue golden in Scene.GoldenUnity("camera"))
            {
                PoseDriver driver = Scene.Driver();
                Transform mesh = driver.Visual.transform;
                mesh.localRotation = UnitySpace.GltfRotation;
                driver.Apply(Scene.Sample(JsonLists.Pose(golden)), null);
                Scene.Near(golden["vertex_in_frame"], mesh.TransformPoint(imported), Single);
            }
            Vector3 byEuler = Quaternion.Euler(0, 180, 0) * imported;
            Vector3 byOurs = UnitySpace.GltfRotation * imported;
            Check.Near(byEuler.z, byOurs.z, 1e-7, "as docs/conventions.md says");
        }

        /// <summary>In the frame of an origin that stands elsewhere: products cancel.</summary>
        public static void PosesAreInTheFrameOfTheOrigin()
        {
            RigidPose anchor = JsonLists.Pose(
                ConventionTests.Golden()["anchor_from_camera"]["unity"]);
            Transform origin = new GameObject("camera").transform;
            origin.SetPositionAndRotation(
                anchor.Position.ToUnity(), anchor.Orientation.ToUnity());
            foreach (JsonValue golden in ConventionTests.Golden()["cases"].Items)
            {
                PoseDriver driver = Scene.Driver();
                driver.Apply(
                    Scene.Sample(JsonLists.Pose(golden["camera"]["unity"])), origin);
                JsonValue wanted = golden["anchor"]["unity"];
                Vector3 there = driver.transform.TransformPoint(
                    JsonLists.Vector(wanted["vertex_in_body"]).ToUnity());
                Scene.Near(wanted["vertex_in_frame"], there, Single);
            }
        }

        /// <summary>Hidden until there is a pose, shown with it, hidden without it.</summary>
        public static void HidesWithoutAPose()
        {
            PoseDriver driver = Scene.Driver();
            int changes = 0;
            driver.VisibilityChanged += isShown => changes++;
            Check.That(!driver.Visual.activeSelf, "hidden at first");
            driver.Apply(Scene.Sample(RigidPose.Identity), null);
            driver.Apply(Scene.Sample(RigidPose.Identity), null);
            Check.That(driver.Visual.activeSelf && driver.IsShown, "shown");
            driver.Apply(default(PoseSample), null);
            Check.That(!driver.Visual.activeSelf && !driver.IsShown, "hidden");
            Check.Equal(2, changes, "told once a change");
            Engine.DisableAll();
        }

        /// <summary>Stale poses are hidden, or stay where they were.</summary>
        public static void HidesWhatIsStale()
        {
            PoseDriver driver = Scene.Driver();
            PoseSample stale = Scene.Sample(RigidPose.Identity);
            stale.IsStale = true;
            driver.Apply(stale, null);
            Check.That(!driver.Visual.activeSelf, "hidden");
            driver.HideWhenStale = false;
            driver.Apply(stale, null);
            Check.That(driver.Visual.activeSelf, "stays");
            Engine.DisableAll();
        }

        /// <summary>An object that would hide itself is refused.</summary>
        public static void RefusesToHideItself()
        {
            Engine.Errors.Clear();
            GameObject part = new GameObject("jaw");
            PoseDriver driver = part.AddComponent<PoseDriver>();
            driver.Visual = part;
            Engine.Enable(driver);
            Check.That(part.activeSelf && driver.Visual == null, "not hidden");
            Check.That(Engine.Errors[0].Contains("child"), "told");
            Engine.DisableAll();
        }
    }
}
