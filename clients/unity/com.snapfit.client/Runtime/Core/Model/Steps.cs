using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>Where a part belongs.</summary>
    public sealed class Ghost
    {
        private Ghost(JsonValue json)
        {
            Part = json["part"].AsString();
            Parent = json["parent"].AsString();
            ParentFromPart = JsonLists.Pose(json);
        }

        /// <summary>What is to be put there.</summary>
        public string Part { get; private set; }

        /// <summary>The part in whose frame the pose is.</summary>
        public string Parent { get; private set; }

        /// <summary>Its place there, metres.</summary>
        public RigidPose ParentFromPart { get; private set; }

        internal static Ghost From(JsonValue json)
        {
            return json.IsNull ? null : new Ghost(json);
        }
    }

    /// <summary>A text at a point of a part.</summary>
    public sealed class Annotation
    {
        private Annotation(JsonValue json)
        {
            Part = json["part"].AsString();
            Anchor = JsonLists.Vector(json["anchor"]);
            Text = json["text"].AsString();
        }

        /// <summary>The part in whose frame the point is.</summary>
        public string Part { get; private set; }

        /// <summary>The point, metres.</summary>
        public Vec3 Anchor { get; private set; }

        /// <summary>What it says.</summary>
        public string Text { get; private set; }

        internal static Annotation From(JsonValue json)
        {
            return new Annotation(json);
        }
    }

    /// <summary>Where a step stands.</summary>
    public enum StepProgress
    {
        /// <summary>It was taken.</summary>
        Finished,

        /// <summary>It can be taken now.</summary>
        Next,

        /// <summary>Not yet, or on another branch.</summary>
        Later,
    }

    /// <summary>An instruction to a person, and where it stands at the station.</summary>
    public sealed class Step
    {
        private Step(JsonValue json)
        {
            Name = json["step"].AsString();
            Title = json["title"].AsString();
            Text = json["text"].AsString();
            FromState = json["from_state"].AsString();
            ToState = json["to_state"].AsString();
            Parts = JsonLists.Strings(json["parts"]);
            Ghost = Ghost.From(json["ghost"]);
            Annotations = JsonLists.Of(json["annotations"], Annotation.From);
            Media = JsonLists.Strings(json["media"]);
            ExpectedDurationS = json["expected_duration_s"].AsDoubleOrNull();
            string progress = json["progress"].AsString();
            Progress = progress == "finished" ? StepProgress.Finished
                : progress == "next" ? StepProgress.Next : StepProgress.Later;
            GhostInFrame = JsonLists.PoseOrNull(json["ghost_in_frame"]);
        }

        /// <summary>Its name.</summary>
        public string Name { get; private set; }

        /// <summary>A few words.</summary>
        public string Title { get; private set; }

        /// <summary>The instruction.</summary>
        public string Text { get; private set; }

        /// <summary>The assembly state that it begins in.</summary>
        public string FromState { get; private set; }

        /// <summary>The assembly state that it leads to.</summary>
        public string ToState { get; private set; }

        /// <summary>The parts that it handles.</summary>
        public IReadOnlyList<string> Parts { get; private set; }

        /// <summary>Where a part belongs; null where the step does not say.</summary>
        public Ghost Ghost { get; private set; }

        /// <summary>Texts at points of parts.</summary>
        public IReadOnlyList<Annotation> Annotations { get; private set; }

        /// <summary>Pictures and films: addresses, or paths of the server.</summary>
        public IReadOnlyList<string> Media { get; private set; }

        /// <summary>Seconds; null where the step does not say.</summary>
        public double? ExpectedDurationS { get; private set; }

        /// <summary>Where it stands.</summary>
        public StepProgress Progress { get; private set; }

        /// <summary>The ghost in the frame of the answer, metres; null while its parent is not
        /// tracked.</summary>
        public RigidPose? GhostInFrame { get; private set; }

        internal static Step From(JsonValue json)
        {
            return new Step(json);
        }
    }
}
