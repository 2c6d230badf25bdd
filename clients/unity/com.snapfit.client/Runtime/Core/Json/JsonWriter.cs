using System;
using System.Globalization;
using System.Text;

namespace Snapfit
{
    /// <summary>Writes the JSON of a request's body, member by member.</summary>
    public sealed class JsonWriter
    {
        private readonly StringBuilder json = new StringBuilder();
        private bool needsComma;

        /// <summary>Begin an object; with a name where it is another one's member.</summary>
        public JsonWriter BeginObject(string name = null)
        {
            Lead(name);
            json.Append('{');
            needsComma = false;
            return this;
        }

        /// <summary>End an object.</summary>
        public JsonWriter EndObject()
        {
            json.Append('}');
            needsComma = true;
            return this;
        }

        /// <summary>A string.</summary>
        public JsonWriter Member(string name, string value)
        {
            Lead(name);
            JsonText.Append(json, value);
            return this;
        }

        /// <summary>A number.</summary>
        /// <exception cref="ArgumentException">JSON has no such number.</exception>
        public JsonWriter Member(string name, double value)
        {
            Lead(name);
            Number(value);
            return this;
        }

        /// <summary>true or false.</summary>
        public JsonWriter Member(string name, bool value)
        {
            Lead(name);
            json.Append(value ? "true" : "false");
            return this;
        }

        /// <summary>Numbers.</summary>
        /// <exception cref="ArgumentException">JSON has no such number.</exception>
        public JsonWriter Member(string name, double[] values)
        {
            Lead(name);
            json.Append('[');
            for (int place = 0; place < values.Length; place++)
            {
                json.Append(place == 0 ? "" : ",");
                Number(values[place]);
            }
            json.Append(']');
            return this;
        }

        /// <summary>Strings.</summary>
        public JsonWriter Member(string name, string[] values)
        {
            Lead(name);
            json.Append('[');
            for (int place = 0; place < values.Length; place++)
            {
                json.Append(place == 0 ? "" : ",");
                JsonText.Append(json, values[place]);
            }
            json.Append(']');
            return this;
        }

        /// <summary>A pose: position in metres, orientation x, y, z, w.</summary>
        /// <exception cref="ArgumentException">It is not finite.</exception>
        public JsonWriter Member(string name, RigidPose pose)
        {
            Vec3 at = pose.Position;
            Quat turn = pose.Orientation;
            return BeginObject(name)
                .Member("position", new[] { at.X, at.Y, at.Z })
                .Member("orientation", new[] { turn.X, turn.Y, turn.Z, turn.W })
                .EndObject();
        }

        /// <summary>What was written.</summary>
        public override string ToString()
        {
            return json.ToString();
        }

        private void Lead(string name)
        {
            json.Append(needsComma ? "," : "");
            needsComma = true;
            if (name != null)
            {
                JsonText.Append(json, name);
                json.Append(':');
            }
        }

        private void Number(double value)
        {
            if (double.IsNaN(value) || double.IsInfinity(value))
            {
                throw new ArgumentException("JSON has no number " + value + ".");
            }
            json.Append(value.ToString("R", CultureInfo.InvariantCulture));
        }
    }
}
