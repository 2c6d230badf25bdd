using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>What a command did.</summary>
    public sealed class CommandResult
    {
        private CommandResult(JsonValue json)
        {
            Command = json["command"].AsString();
            Changed = json["changed"].AsBool();
            Done = JsonLists.Strings(json["done"]);
            State = json["state"].AsStringOrNull();
        }

        /// <summary>Which command it was.</summary>
        public string Command { get; private set; }

        /// <summary>False where all was so already.</summary>
        public bool Changed { get; private set; }

        /// <summary>What was done, for people.</summary>
        public IReadOnlyList<string> Done { get; private set; }

        /// <summary>The assembly state that holds now, or null.</summary>
        public string State { get; private set; }

        /// <summary>From an answer's JSON.</summary>
        /// <exception cref="JsonFormatException">Something is missing.</exception>
        public static CommandResult From(JsonValue json)
        {
            return new CommandResult(json);
        }
    }
}
