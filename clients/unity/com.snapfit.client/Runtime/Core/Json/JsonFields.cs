using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>Small values of the contract, as a reader comes to them.</summary>
    internal static class JsonFields
    {
        /// <summary>A string, or null.</summary>
        public static string StringOrNull(JsonReader json)
        {
            return json.TakeNull() ? null : json.ReadString();
        }

        /// <summary>A number, or null.</summary>
        public static double? NumberOrNull(JsonReader json)
        {
            return json.TakeNull() ? (double?)null : json.ReadDouble();
        }

        /// <summary>So many numbers, no more and no less.</summary>
        public static void Numbers(JsonReader json, double[] into, int wanted)
        {
            int read = 0;
            json.BeginArray();
            while (json.NextItem())
            {
                double number = json.ReadDouble();
                if (read < wanted)
                {
                    into[read] = number;
                }
                read++;
            }
            if (read != wanted)
            {
                throw new JsonFormatException(
                    "The answer has " + read + " numbers where " + wanted + " belong.");
            }
        }

        /// <summary>Strings, in place of those in the list.</summary>
        public static void Strings(JsonReader json, List<string> into)
        {
            into.Clear();
            json.BeginArray();
            while (json.NextItem())
            {
                into.Add(json.ReadString());
            }
        }
    }
}
