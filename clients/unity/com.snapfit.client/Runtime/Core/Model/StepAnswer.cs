using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>One step, or all of them, at a station now.</summary>
    public sealed class StepAnswer
    {
        private StepAnswer(JsonValue json)
        {
            Asset = json["asset"].AsString();
            BootId = json["boot_id"].AsString();
            Stale = json["stale"].AsBool();
            Frame = json["frame"].AsString();
            Convention = ConventionNames.Parse(json["convention"].AsString());
            State = json["state"].AsString();
            JsonValue one = json.Find("step");
            Steps = one.IsNull
                ? JsonLists.Of(json["steps"], Step.From)
                : new List<Step> { Step.From(one) };
            Alternatives = JsonLists.StringsOrNone(json.Find("alternatives"));
        }

        /// <summary>The asset under assembly.</summary>
        public string Asset { get; private set; }

        /// <summary>The run of the worker that it belongs to.</summary>
        public string BootId { get; private set; }

        /// <summary>The worker is down or its snapshot too old.</summary>
        public bool Stale { get; private set; }

        /// <summary>The frame of the ghosts in it.</summary>
        public string Frame { get; private set; }

        /// <summary>The axes of ghosts and annotations.</summary>
        public Convention Convention { get; private set; }

        /// <summary>The assembly state.</summary>
        public string State { get; private set; }

        /// <summary>The step that was asked for, or all in the order of the asset.</summary>
        public IReadOnlyList<Step> Steps { get; private set; }

        /// <summary>The step that was asked for, or the first.</summary>
        public Step Step
        {
            get { return Steps[0]; }
        }

        /// <summary>Other steps that can be taken now.</summary>
        public IReadOnlyList<string> Alternatives { get; private set; }

        /// <summary>From an answer's JSON.</summary>
        /// <exception cref="JsonFormatException">Something is missing.</exception>
        public static StepAnswer From(JsonValue json)
        {
            return new StepAnswer(json);
        }
    }
}
