using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>A part that rests on another one as it should not.</summary>
    public sealed class Misassembly
    {
        /// <summary>The part that is wrong.</summary>
        public string Part { get; internal set; }

        /// <summary>What it touches, or is linked to.</summary>
        public string Parent { get; internal set; }

        /// <summary>wrong_place, wrong_way_round, wrong_part or wrong_order.</summary>
        public string Kind { get; internal set; }

        /// <summary>How far it is from its own place, metres; null if it has none now.</summary>
        public double? TranslationM { get; internal set; }

        /// <summary>How far it is turned against its own place, radians; null if it has none now.
        /// </summary>
        public double? RotationRad { get; internal set; }
    }

    /// <summary>The assembly, as every snapshot carries it.</summary>
    public sealed class AssemblySummary
    {
        /// <summary>Name of the assembly state.</summary>
        public string State { get; internal set; }

        /// <summary>0 to 1, that this state holds.</summary>
        public double Confidence { get; internal set; }

        /// <summary>Steps that were taken, in order.</summary>
        public List<string> FinishedSteps { get; } = new List<string>();

        /// <summary>Steps that can be taken now; empty at the end.</summary>
        public List<string> NextSteps { get; } = new List<string>();

        /// <summary>What sits wrong.</summary>
        public List<Misassembly> Misassemblies { get; } = new List<Misassembly>();

        /// <summary>tracking or operator.</summary>
        public string DecidedBy { get; internal set; }

        /// <summary>Exposure of the first frame in this state, microseconds of the server's time.
        /// </summary>
        public long SinceUs { get; internal set; }

        /// <summary>Grows with every change but that of the confidence, in one boot_id.</summary>
        public long Revision { get; internal set; }
    }
}
