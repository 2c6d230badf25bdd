using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>The assembly at the latest snapshot, as it is asked for by itself.</summary>
    public sealed class AssemblyAnswer
    {
        private AssemblyAnswer(JsonValue json)
        {
            BootId = json["boot_id"].AsString();
            Stale = json["stale"].AsBool();
            State = json["state"].AsString();
            Confidence = json["confidence"].AsDouble();
            FinishedSteps = JsonLists.Strings(json["finished_steps"]);
            NextSteps = JsonLists.Strings(json["next_steps"]);
            Misassemblies = JsonLists.Of(json["misassemblies"], Wrong);
            DecidedBy = json["decided_by"].AsString();
            Revision = json["revision"].AsLong();
        }

        /// <summary>The run of the worker that it belongs to.</summary>
        public string BootId { get; private set; }

        /// <summary>The worker is down or its snapshot too old.</summary>
        public bool Stale { get; private set; }

        /// <summary>Name of the assembly state.</summary>
        public string State { get; private set; }

        /// <summary>0 to 1, that this state holds.</summary>
        public double Confidence { get; private set; }

        /// <summary>Steps that were taken, in order.</summary>
        public IReadOnlyList<string> FinishedSteps { get; private set; }

        /// <summary>Steps that can be taken now; empty at the end.</summary>
        public IReadOnlyList<string> NextSteps { get; private set; }

        /// <summary>What sits wrong.</summary>
        public IReadOnlyList<Misassembly> Misassemblies { get; private set; }

        /// <summary>tracking or operator.</summary>
        public string DecidedBy { get; private set; }

        /// <summary>Grows with every change but that of the confidence, in one boot_id.</summary>
        public long Revision { get; private set; }

        /// <summary>From an answer's JSON.</summary>
        /// <exception cref="JsonFormatException">Something is missing.</exception>
        public static AssemblyAnswer From(JsonValue json)
        {
            return new AssemblyAnswer(json);
        }

        private static Misassembly Wrong(JsonValue json)
        {
            return new Misassembly
            {
                Part = json["part"].AsString(),
                Parent = json["parent"].AsString(),
                Kind = json["kind"].AsString(),
                TranslationM = json["translation_m"].AsDoubleOrNull(),
                RotationRad = json["rotation_rad"].AsDoubleOrNull(),
            };
        }
    }
}
