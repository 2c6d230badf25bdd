using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>One workbench: what it tracks, and how its worker does.</summary>
    public sealed class StationInfo
    {
        private StationInfo(JsonValue json)
        {
            Name = json["station"].AsString();
            StaleAfterS = json["stale_after_s"].AsDouble();
            Stale = json["stale"].AsBool();
            JsonValue facts = json["facts"];
            Asset = facts.Find("asset").AsStringOrNull();
            FrameRateHz = facts.Find("frame_rate_hz").AsDoubleOrNull();
            Parts = JsonLists.StringsOrNone(facts.Find("parts"));
            WorkerPhase = json["worker"]["phase"].AsString();
            WorkerMessage = json["worker"]["message"].AsString();
        }

        /// <summary>Its name.</summary>
        public string Name { get; private set; }

        /// <summary>Older snapshots are stale, seconds.</summary>
        public double StaleAfterS { get; private set; }

        /// <summary>Whether it has nothing fresh.</summary>
        public bool Stale { get; private set; }

        /// <summary>The asset under assembly; null for loose parts, and until the worker has
        /// opened its source.</summary>
        public string Asset { get; private set; }

        /// <summary>Frames a second; null until the worker has opened its source.</summary>
        public double? FrameRateHz { get; private set; }

        /// <summary>The tracked parts.</summary>
        public IReadOnlyList<string> Parts { get; private set; }

        /// <summary>starting, running, ended or failed.</summary>
        public string WorkerPhase { get; private set; }

        /// <summary>What the worker is doing, or what went wrong.</summary>
        public string WorkerMessage { get; private set; }

        /// <summary>From an answer's JSON.</summary>
        /// <exception cref="JsonFormatException">Something is missing.</exception>
        public static StationInfo From(JsonValue json)
        {
            return new StationInfo(json);
        }
    }
}
