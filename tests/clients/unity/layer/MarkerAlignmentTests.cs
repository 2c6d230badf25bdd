using System;
using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Tests
{
    /// <summary>A marker's axes, its middle and the origin of the world.</summary>
    public static class MarkerAlignmentTests
    {
        private const double Single = 1e-6;

        /// <summary>Each tracker's axes: where its right, up the page and into the page go.
        /// </summary>
        public static void TrackersAxesBecomeSnapfits()
        {
            Axes(MarkerAxes.ZIntoThePage, new Vec3(1, 0, 0), new Vec3(0, 1, 0), new Vec3(0, 0, 1));
            Axes(MarkerAxes.ZOutOfThePage, new Vec3(-1, 0, 0), new Vec3(0, 1, 0),
                new Vec3(0, 0, -1));
            Axes(MarkerAxes.YOutOfThePage, new Vec3(1, 0, 0), new Vec3(0, 0, 1),
                new Vec3(0, -1, 0));
            Axes(MarkerAxes.YDownThePage, new Vec3(1, 0, 0), new Vec3(0, -1, 0),
                new Vec3(0, 0, -1));
        }

        /// <summary>A tracker that gives the code's top left corner, y down the page.</summary>
        public static void ACornerBecomesTheMiddle()
        {
            MarkerAlignment alignment = New();
            alignment.Axes = MarkerAxes.YDownThePage;
            alignment.Middle = new Vector2(0.1f, -0.1f);
            // A code of 20 cm on a wall ahead, upright: its corner is up and to the left, its axes
            // x right, y down, z towards the reader.
            RigidPose pose = alignment.WorldFromMarker(
                new Vector3(-0.1f, 1.6f, 2), new Quaternion(1, 0, 0, 0));
            Check.Near(new Vec3(0, 1.5, 2), pose.Position, Single, "middle");
            Check.Near(Quat.Identity, pose.Orientation, Single, "upright on the wall ahead");
        }

        /// <summary>In the frame of an origin, not in Unity's world.</summary>
        public static void TheOriginIsTakenOut()
        {
            MarkerAlignment alignment = New();
            Transform origin = new GameObject("session").transform;
            origin.SetPositionAndRotation(new Vector3(1, 2, 3), Quaternion.Euler(10, 20, 30));
            alignment.Connection.Origin = origin;
            Vector3 inOrigin = new Vector3(0.3f, -0.4f, 0.5f);
            Quaternion turned = Quaternion.Euler(0, 90, 0);
            RigidPose pose = alignment.WorldFromMarker(
                origin.TransformPoint(inOrigin), origin.rotation * turned);
            Check.Near(new Vec3(0.3, -0.4, 0.5), pose.Position, Single, "position");
            Check.Near(Quat.Exp(new Vec3(0, Math.PI / 2, 0)), pose.Orientation, Single, "turn");
        }

        /// <summary>Without a name for the anchor nothing is sent, and it says why.</summary>
        public static void SaysThatAnAnchorNeedsAName()
        {
            MarkerAlignment alignment = New();
            alignment.Connection.Address = "http://127.0.0.1:9";
            Engine.Enable(alignment.Connection, alignment);
            alignment.Report(Vector3.zero, Quaternion.identity);
            Engine.Frame(1);
            Check.That(alignment.Problem.Contains("name"), alignment.Problem);
            Engine.DisableAll();
        }

        private static MarkerAlignment New()
        {
            MarkerAlignment alignment = new GameObject("alignment").AddComponent<MarkerAlignment>();
            alignment.Connection = new GameObject("snapfit").AddComponent<SnapfitConnection>();
            return alignment;
        }

        private static void Axes(MarkerAxes axes, Vec3 right, Vec3 up, Vec3 into)
        {
            Quat turn = MarkerAxesMap.TrackedFromMarker(axes);
            Check.Near(right, turn.Rotate(new Vec3(1, 0, 0)), Single, axes + " right");
            Check.Near(up, turn.Rotate(new Vec3(0, 1, 0)), Single, axes + " up the page");
            Check.Near(into, turn.Rotate(new Vec3(0, 0, 1)), Single, axes + " into the page");
        }
    }
}
