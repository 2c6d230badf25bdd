using System;
using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Tests
{
    /// <summary>Ghosts, and a connection without a server.</summary>
    public static class GuideTests
    {
        private static readonly string Answer = "{\"asset\":\"a\",\"boot_id\":\"b\","
            + "\"stale\":false,\"frame\":\"camera\",\"convention\":\"unity\",\"state\":\"free\","
            + "\"step\":{\"step\":\"mount-jaw\",\"title\":\"Mount the jaw\",\"text\":\"Put it.\","
            + "\"from_state\":\"free\",\"to_state\":\"mounted\",\"parts\":[\"base\",\"jaw\"],"
            + "\"ghost\":{\"part\":\"jaw\",\"parent\":\"base\",\"position\":[0.01,0.02,0.03],"
            + "\"orientation\":[0,0,0,1]},\"annotations\":[{\"part\":\"jaw\",\"anchor\":[1,2,3],"
            + "\"text\":\"up\"}],\"media\":[\"/v1/assets/a/media/x.png\"],"
            + "\"expected_duration_s\":8,\"progress\":\"next\",\"ghost_in_frame\":null},"
            + "\"alternatives\":[\"screw-bolt\"]}";

        /// <summary>A step as the server tells it.</summary>
        public static void AStepIsRead()
        {
            StepAnswer answer = StepAnswer.From(JsonValue.Parse(Answer));
            Check.Equal("Mount the jaw", answer.Step.Title);
            Check.Equal(StepProgress.Next, answer.Step.Progress);
            Check.Equal("jaw", answer.Step.Ghost.Part);
            Check.Equal("up", answer.Step.Annotations[0].Text);
            Check.Near(new Vec3(1, 2, 3), answer.Step.Annotations[0].Anchor, 0, "anchor");
            Check.Near(8, answer.Step.ExpectedDurationS.Value, 0, "duration");
            Check.That(answer.Step.GhostInFrame == null, "parent not tracked");
            Check.Equal("screw-bolt", answer.Alternatives[0]);
        }

        /// <summary>The ghost sits on the part that will carry it, and only its mesh is shown.
        /// </summary>
        public static void TheGhostSitsOnItsParent()
        {
            GhostDriver driver = Ghosts();
            Ghost ghost = StepAnswer.From(JsonValue.Parse(Answer)).Step.Ghost;
            RigidPose parent = new RigidPose(
                new Vec3(1, 0, 0), Quat.Exp(new Vec3(0, 0, Math.PI / 2)));
            driver.Apply(ghost, Scene.Sample(parent), null);
            Vec3 wanted = parent.Apply(new Vec3(0.01, 0.02, 0.03));
            Vector3 there = driver.transform.position;
            Check.Near(wanted, new Vec3(there.x, there.y, there.z), 1e-6, "place");
            Check.That(driver.Visuals[0].Visual.activeSelf, "the jaw's mesh");
            Check.That(!driver.Visuals[1].Visual.activeSelf, "not the bolt's");
            Engine.DisableAll();
        }

        /// <summary>No ghost while its parent has no pose or a stale one, or the step has none.
        /// </summary>
        public static void NoGhostWithoutItsParent()
        {
            GhostDriver driver = Ghosts();
            Ghost ghost = StepAnswer.From(JsonValue.Parse(Answer)).Step.Ghost;
            PoseSample stale = Scene.Sample(RigidPose.Identity);
            stale.IsStale = true;
            foreach (PoseSample parent in new[] { default(PoseSample), stale })
            {
                driver.Apply(ghost, Scene.Sample(RigidPose.Identity), null);
                Check.Equal("jaw", driver.Shown);
                driver.Apply(ghost, parent, null);
                Check.That(driver.Shown == null, "hidden");
                Check.That(!driver.Visuals[0].Visual.activeSelf, "its mesh");
            }
            driver.Apply(ghost, Scene.Sample(RigidPose.Identity), null);
            driver.Apply(null, Scene.Sample(RigidPose.Identity), null);
            Check.That(driver.Shown == null, "no ghost in the step");
            Engine.DisableAll();
        }

        /// <summary>A wrong address is told in the console, and nothing runs.</summary>
        public static void AWrongAddressIsTold()
        {
            Engine.Errors.Clear();
            SnapfitConnection connection =
                new GameObject("snapfit").AddComponent<SnapfitConnection>();
            connection.Address = "192.168.1.20:8000";
            Engine.Enable(connection);
            Engine.Frame(0.02);
            Check.Equal(FeedState.Stopped, connection.State);
            Check.That(Engine.Errors[0].Contains("http://192.168.1.20:8000"), "told");
            Check.That(connection.Sample("jaw").Kind == SampleKind.None, "no pose");
            Engine.DisableAll();
        }

        private static GhostDriver Ghosts()
        {
            GhostDriver driver = new GameObject("ghosts").AddComponent<GhostDriver>();
            driver.Visuals = new[]
            {
                new GhostDriver.PartVisual { Part = "jaw", Visual = new GameObject("jaw") },
                new GhostDriver.PartVisual { Part = "bolt", Visual = new GameObject("bolt") },
            };
            Engine.Enable(driver);
            return driver;
        }
    }
}
