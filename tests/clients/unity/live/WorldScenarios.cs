using System;
using System.Threading;
using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Tests
{
    /// <summary>The layer for Unity, run frame by frame against a real server.</summary>
    public static class WorldScenarios
    {
        private const double FrameS = 0.016;

        /// <summary>The headset tells where it sees the marker; then parts are where they are in
        /// its world. The marker of the server's camera is where the script says.</summary>
        public static void World(SnapfitOptions options)
        {
            SnapfitConnection connection = Connection(options, "headset-7");
            connection.PlayoutDelayMs = 0;
            MarkerAlignment alignment = new GameObject("marker").AddComponent<MarkerAlignment>();
            alignment.Connection = connection;
            alignment.Board = new ArucoMarker(7, 0.25);
            PoseDriver pad = Driver(connection, "pad");
            PoseDriver cap = Driver(connection, "cap");
            Engine.Enable(connection, alignment, pad, cap);
            Frames(() => connection.State == FeedState.Refused, 30, "no anchor yet");
            Check.That(connection.Problem.Contains("headset-7"), connection.Problem);
            Check.That(!pad.IsShown, "nothing shown");

            // The wearer's world: the camera hangs 1.5 m high and looks down.
            RigidPose worldFromCamera = new RigidPose(
                new Vec3(0.4, 1.5, 2), Quat.Exp(new Vec3(1.1, 0.2, -0.1)));
            ConventionMap map = new ConventionMap(Convention.OpenCv, Convention.Unity);
            // CAMERA_FROM_MARKER of the scripted pipeline.
            RigidPose cameraFromMarker = map.Pose(new RigidPose(
                new Vec3(0.02, 0.01, 0.5), Quat.Exp(new Vec3(0.6, 0.5, 0.3))));
            RigidPose marker = worldFromCamera * cameraFromMarker;
            Frames(() =>
            {
                alignment.Report(marker.Position.ToUnity(), marker.Orientation.ToUnity());
                return alignment.IsAligned && pad.IsShown;
            }, 30, "aligned and shown: " + alignment.Problem);
            Check.That(alignment.Latest.Residual.TranslationM < 1e-4, "residual");
            // As exact as the server's camera, a small picture, finds the marker.
            RigidPose found = alignment.Latest.WorldFromCamera.Value;
            Check.Near(worldFromCamera.Position, found.Position, 0.03, "where the camera is");
            Check.Near(worldFromCamera.Orientation, found.Orientation, 0.06, "how it looks");
            Compare(found, connection, pad);
            Check.That(!cap.IsShown, "a lost part is hidden");

            Pause(connection, pad);
            End();
        }

        private static void Pause(SnapfitConnection connection, PoseDriver pad)
        {
            Engine.Call(connection, "OnApplicationPause", true);
            Engine.Frame(FrameS);
            Check.Equal(FeedState.Stopped, connection.State, "paused");
            Check.That(!pad.IsShown, "hidden while paused");
            Engine.Call(connection, "OnApplicationPause", false);
            Frames(() => pad.IsShown, 30, "shown again");
        }

        /// <summary>Steps and ghosts, through an operator's commands, to the end.</summary>
        public static void Guide(SnapfitOptions options)
        {
            SnapfitConnection connection = Connection(options, "");
            StepGuide guide = new GameObject("guide").AddComponent<StepGuide>();
            guide.Connection = connection;
            StepPanel panel = new GameObject("panel").AddComponent<StepPanel>();
            panel.Guide = guide;
            string title = null;
            string note = null;
            panel.Title.AddListener(it => title = it);
            panel.Note.AddListener(it => note = it);
            GhostDriver ghosts = new GameObject("ghosts").AddComponent<GhostDriver>();
            ghosts.Guide = guide;
            GameObject mesh = new GameObject("jaw");
            ghosts.Visuals = new[] { new GhostDriver.PartVisual { Part = "jaw", Visual = mesh } };
            PoseDriver parent = Driver(connection, "base");
            int events = 0;
            connection.EventTaken += it => events++;
            Engine.Enable(connection, guide, panel, ghosts, parent);

            Frames(() => title == "Mount the jaw" && mesh.activeSelf, 30, "first step and ghost");
            Check.Equal("0 done", note);
            Vector3 wanted = parent.transform.TransformPoint(new Vector3(0.01f, -0.02f, 0.03f));
            Vector3 there = ghosts.transform.position;
            // Both are asked for one after the other in a frame, while the base moves along x.
            Check.Near(wanted.y, there.y, 1e-4, "the ghost sits on the base, y");
            Check.Near(wanted.z, there.z, 1e-4, "the ghost sits on the base, z");
            Check.Near(wanted.x, there.x, 0.05, "the ghost sits on the base, x");

            Set(connection, "jaw-mounted");
            Frames(() => title == "Screw in the bolt" && note == "1 done", 30, "next step");
            Check.That(!mesh.activeSelf, "the jaw's ghost is gone");
            Set(connection, "assembled");
            Frames(() => guide.IsFinished && title == "Done", 30, "nothing left to do");
            Set(connection, "free");
            Frames(() => title == "Mount the jaw" && !guide.IsFinished, 30, "begun anew");
            // Over another connection, which may have been opened later than all that.
            Frames(
                () =>
                {
                    if (events == 0)
                    {
                        Set(connection, "jaw-mounted");
                        Set(connection, "free");
                    }
                    return events > 0;
                },
                30,
                "events came too");
            End();
        }

        private static SnapfitConnection Connection(SnapfitOptions options, string anchorId)
        {
            SnapfitConnection connection =
                new GameObject("snapfit").AddComponent<SnapfitConnection>();
            connection.Address = options.Address.ToString();
            connection.AnchorId = anchorId;
            return connection;
        }

        private static PoseDriver Driver(SnapfitConnection connection, string part)
        {
            PoseDriver driver = new GameObject(part).AddComponent<PoseDriver>();
            driver.Connection = connection;
            driver.Part = part;
            driver.Visual = new GameObject("mesh");
            driver.Visual.transform.parent = driver.transform;
            return driver;
        }

        // Parts move along the camera's x at 0.1 m/s and do not turn; the driver is a little
        // later than the snapshot.
        private static void Compare(
            RigidPose worldFromCamera, SnapfitConnection connection, PoseDriver driver)
        {
            PartPose part = null;
            using (SnapfitClient client = new SnapfitClient(
                new SnapfitOptions(connection.Address)))
            {
                part = Live.Get(client.GetPosesAsync).Find(driver.Part);
            }
            Engine.Frame(FrameS);
            RigidPose wanted = worldFromCamera * part.Pose;
            Vector3 at = driver.transform.position;
            Vec3 inCamera = worldFromCamera.Inverse.Apply(new Vec3(at.x, at.y, at.z));
            Check.Near(part.Pose.Position.Y, inCamera.Y, 2e-3, "y in the camera");
            Check.Near(part.Pose.Position.Z, inCamera.Z, 2e-3, "z in the camera");
            Check.Near(part.Pose.Position.X, inCamera.X, 0.2, "x in the camera");
            Quaternion turned = driver.transform.rotation;
            Check.Near(wanted.Orientation, new Quat(turned.x, turned.y, turned.z, turned.w),
                5e-3, "orientation in the world");
        }

        private static void Set(SnapfitConnection connection, string state)
        {
            Live.Get(token => connection.Client.SetStateAsync(state, token));
        }

        private static void Frames(Func<bool> holds, double limitS, string what)
        {
            Live.Until(() =>
            {
                Engine.Frame(FrameS);
                Thread.Sleep(10);
                return holds();
            }, limitS, what);
        }

        private static void End()
        {
            Engine.DisableAll();
            Check.That(Engine.Errors.Count == 0, string.Join("; ", Engine.Errors.ToArray()));
        }
    }
}
