using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>Reads the assembly of a snapshot into an object that is used again.</summary>
    internal static class AssemblyReader
    {
        /// <summary>Reads one.</summary>
        /// <param name="json">Stands before it.</param>
        /// <param name="into">What it had is overwritten.</param>
        public static void Read(JsonReader json, AssemblySummary into)
        {
            string name;
            json.BeginObject();
            while (json.NextName(out name))
            {
                switch (name)
                {
                    case "state":
                        into.State = json.ReadString();
                        break;
                    case "confidence":
                        into.Confidence = json.ReadDouble();
                        break;
                    case "finished_steps":
                        JsonFields.Strings(json, into.FinishedSteps);
                        break;
                    case "next_steps":
                        JsonFields.Strings(json, into.NextSteps);
                        break;
                    case "misassemblies":
                        Misassemblies(json, into.Misassemblies);
                        break;
                    case "decided_by":
                        into.DecidedBy = json.ReadString();
                        break;
                    case "since_us":
                        into.SinceUs = json.ReadLong();
                        break;
                    case "revision":
                        into.Revision = json.ReadLong();
                        break;
                    default:
                        json.Skip();
                        break;
                }
            }
        }

        private static void Misassemblies(JsonReader json, List<Misassembly> into)
        {
            into.Clear();
            json.BeginArray();
            while (json.NextItem())
            {
                Misassembly wrong = new Misassembly();
                string name;
                json.BeginObject();
                while (json.NextName(out name))
                {
                    switch (name)
                    {
                        case "part":
                            wrong.Part = json.ReadString();
                            break;
                        case "parent":
                            wrong.Parent = json.ReadString();
                            break;
                        case "kind":
                            wrong.Kind = json.ReadString();
                            break;
                        case "translation_m":
                            wrong.TranslationM = JsonFields.NumberOrNull(json);
                            break;
                        case "rotation_rad":
                            wrong.RotationRad = JsonFields.NumberOrNull(json);
                            break;
                        default:
                            json.Skip();
                            break;
                    }
                }
                into.Add(wrong);
            }
        }
    }
}
