namespace Snapfit
{
    /// <summary>Something that happened at the station.</summary>
    public sealed class SnapfitEvent
    {
        internal SnapfitEvent(string id, string kind, JsonValue data)
        {
            Id = id;
            Kind = kind;
            Data = data;
        }

        /// <summary>Names it; what comes after it is asked for by it. May be null.</summary>
        public string Id { get; private set; }

        /// <summary>state_changed, step_finished, step_undone, misassembled, part_found,
        /// part_lost, stale, recovered, anchor_drift; missed where events before this one are no
        /// longer kept: ask for the state anew.</summary>
        public string Kind { get; private set; }

        /// <summary>All that the event tells, by the names of docs/api.md.</summary>
        public JsonValue Data { get; private set; }

        /// <summary>When it was noted, microseconds of the server's time; 0 of a missed.</summary>
        public long AtUs
        {
            get { return Data.Find("at_us").AsLongOrNull() ?? 0; }
        }

        /// <summary>The part that it is about, or null.</summary>
        public string Part
        {
            get { return Data.Find("part").AsStringOrNull(); }
        }

        /// <summary>The step that it is about, or null.</summary>
        public string Step
        {
            get { return Data.Find("step").AsStringOrNull(); }
        }

        /// <summary>The assembly state that holds after it, or null.</summary>
        public string ToState
        {
            get { return Data.Find("to_state").AsStringOrNull(); }
        }

        /// <summary>tracking or operator, or null.</summary>
        public string DecidedBy
        {
            get { return Data.Find("decided_by").AsStringOrNull(); }
        }
    }
}
