using System;
using System.Collections.Generic;
using System.Threading;

namespace Snapfit.Tests
{
    /// <summary>One request, one answer.</summary>
    public static class RequestScenarios
    {
        private static readonly Convention[] All =
        {
            Convention.OpenCv, Convention.OpenXr, Convention.Unity, Convention.Ros,
            Convention.RosOptical,
        };

        /// <summary>Everything that can be asked for.</summary>
        public static void Requests(SnapfitOptions options)
        {
            using (SnapfitClient client = new SnapfitClient(options))
            {
                StationInfo station = Live.Get(client.GetStationsAsync)[0];
                Check.Equal("bench-1", station.Name);
                Check.Equal("running", station.WorkerPhase);
                Check.Equal(8, station.Parts.Count, "parts");
                AssemblyAnswer assembly = Live.Get(client.GetAssemblyAsync);
                Check.Equal("free", assembly.State);
                Check.Equal("mount-jaw", assembly.NextSteps[0]);
                Steps(client);
                byte[] mesh = Live.Get(token => client.GetMeshAsync(station.Asset, "jaw", token));
                Check.Equal("glTF", System.Text.Encoding.ASCII.GetString(mesh, 0, 4), "mesh");
                Live.Until(() => IsQuick(Live.Get(client.GetTimeAsync)), 30, "a round trip");
                Conventions(options);
                NotModified(options, client);
            }
        }

        /// <summary>What the server says no to.</summary>
        public static void Refusals(SnapfitOptions options)
        {
            using (SnapfitClient client = new SnapfitClient(options))
            {
                ProblemException step = Live.ProblemOf(token => client.GetStepAsync("fly", token));
                Check.Equal(404, step.Status);
                Check.Equal("unknown-step", step.Kind);
                Check.That(step.Detail.Contains("mount-jaw"), step.Detail);
                Check.Equal("/v1/steps/fly", step.Instance);
                ProblemException state = Live.ProblemOf(
                    token => client.SetStateAsync("no-such-state", token));
                Check.Equal("unknown-state", state.Kind);
                Check.That(((ICollection<string>)state.Names("names")).Contains("assembled"),
                    "names those that there are");
                ProblemException finder = Live.ProblemOf(client.ResetAndAllAsync);
                Check.Equal("no-detector", finder.Kind);
                ProblemException anchor = Live.ProblemOf(
                    token => client.GetAnchorAsync("nobody", token));
                Check.Equal("unknown-anchor", anchor.Kind);
            }
            options.Station = "bench 9";
            using (SnapfitClient client = new SnapfitClient(options))
            {
                ProblemException station = Live.ProblemOf(client.GetPosesAsync);
                Check.Equal("unknown-station", station.Kind);
            }
            using (SnapfitClient nobody = new SnapfitClient(
                new SnapfitOptions("http://127.0.0.1:1")))
            {
                Check.Throws<UnreachableException>(
                    () => Live.Get(nobody.GetPosesAsync), "No connection to http://127.0.0.1:1/");
            }
        }

        /// <summary>An operator's commands; the server has something that finds parts.</summary>
        public static void Commands(SnapfitOptions options)
        {
            using (SnapfitClient client = new SnapfitClient(options))
            {
                // A part that is still looked for is not looked for again.
                Live.Until(
                    () => Live.Get(client.GetPosesAsync).Find("jaw").HasPose, 30, "finds the jaw");
                CommandResult set = Live.Get(token => client.SetStateAsync("jaw-mounted", token));
                Check.That(set.Changed, "changed");
                Check.Equal("jaw-mounted", set.State);
                Check.Equal("operator", Live.Get(client.GetAssemblyAsync).DecidedBy);
                CommandResult again = Live.Get(token => client.SetStateAsync("jaw-mounted", token));
                Check.That(!again.Changed && again.Done.Count == 0, "not twice");
                CommandResult search = Live.Get(
                    token => client.ReinitialiseAsync(new[] { "jaw" }, token));
                Check.That(search.Changed && search.Done[0].Contains("jaw"), "looks for the jaw");
                CommandResult reset = Live.Get(client.ResetAsync);
                Check.Equal("free", reset.State);
                Check.That(string.Join(" ", reset.Done).Contains("pin"), "looks for the pin too");
            }
        }

        // Without names it means all parts.
        private static System.Threading.Tasks.Task<CommandResult> ResetAndAllAsync(
            this SnapfitClient client, CancellationToken token)
        {
            return client.ReinitialiseAsync(new string[0], token);
        }

        private static void Steps(SnapfitClient client)
        {
            StepAnswer all = Live.Get(client.GetStepsAsync);
            Check.Equal(2, all.Steps.Count, "steps");
            Check.Equal(StepProgress.Later, all.Steps[1].Progress);
            StepAnswer current = Live.Get(client.GetCurrentStepAsync);
            Check.Equal("Mount the jaw", current.Step.Title);
            Check.Equal(Convention.Unity, current.Convention);
            // The scripted ghost is at (0.01, 0.02, 0.03), turned by half a radian about z, along
            // OpenCV's axes.
            Check.Near(new Vec3(0.01, -0.02, 0.03), current.Step.Ghost.ParentFromPart.Position,
                1e-9, "ghost");
            Check.Near(Quat.Exp(new Vec3(0, 0, -0.5)),
                current.Step.Ghost.ParentFromPart.Orientation, 1e-9, "ghost's turn");
            Check.Near(new Vec3(0.1, -0.2, 0.3), current.Step.Annotations[0].Anchor, 1e-9,
                "annotation");
            Check.Equal("screw-bolt", Live.Get(
                token => client.GetStepAsync("screw-bolt", token)).Step.Name);
        }

        // The scripted parts move, but do not turn.
        private static void Conventions(SnapfitOptions options)
        {
            Quat reference = Quat.Identity;
            foreach (Convention convention in All)
            {
                options.Convention = convention;
                using (SnapfitClient client = new SnapfitClient(options))
                {
                    PoseSnapshot snapshot = Live.Get(client.GetPosesAsync);
                    Check.Equal(convention, snapshot.Convention);
                    PartPose jaw = snapshot.Find("jaw");
                    reference = convention == Convention.OpenCv
                        ? jaw.Pose.Orientation : reference;
                    ConventionMap map = new ConventionMap(Convention.OpenCv, convention);
                    Check.Near(map.Orientation(reference), jaw.Pose.Orientation, 1e-6,
                        convention + " jaw");
                    Check.Near(map.Vector(new Vec3(0.1, 0, 0)), jaw.LinearVelocity, 0.02,
                        convention + " velocity");
                    Check.Equal(PartStatus.Lost, snapshot.Find("cap").Status);
                    Check.Equal("base", jaw.LinkedTo);
                }
            }
            options.Convention = Convention.Unity;
        }

        private static bool IsQuick(ClockSample time)
        {
            Check.That(time.RoundTripUs >= 0, "round trip");
            return time.RoundTripUs < 2000000;
        }

        private static void NotModified(SnapfitOptions options, SnapfitClient client)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            string path = options.StationPath("/poses") + options.ViewQuery;
            Live.Until(
                () =>
                {
                    int status = Live.Get(
                        token => client.Channel.GetAsync(path, buffer, 0, token));
                    return status == 304 && buffer.Count == 0 && buffer.ETag != null;
                },
                30,
                "304 by ETag, which is kept");
        }
    }
}
