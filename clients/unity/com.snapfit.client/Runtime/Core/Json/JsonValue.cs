using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>What a JSON value is.</summary>
    public enum JsonKind
    {
        /// <summary>null.</summary>
        Null,

        /// <summary>true or false.</summary>
        Bool,

        /// <summary>A number.</summary>
        Number,

        /// <summary>A string.</summary>
        String,

        /// <summary>An array.</summary>
        Array,

        /// <summary>An object.</summary>
        Object,
    }

    /// <summary>A JSON value as a tree, for what is asked for now and then; snapshots are read by
    /// <see cref="SnapshotReader"/>, which builds none.</summary>
    public sealed class JsonValue
    {
        private static readonly JsonValue NullValue = new JsonValue(JsonKind.Null);
        private static readonly List<JsonValue> NoItems = new List<JsonValue>();

        private readonly List<JsonValue> items = NoItems;
        private readonly Dictionary<string, JsonValue> members;
        private readonly string text;
        private readonly JsonNumber number;
        private readonly bool truth;

        private JsonValue(JsonKind kind)
        {
            Kind = kind;
        }

        private JsonValue(string text)
            : this(JsonKind.String)
        {
            this.text = text;
        }

        private JsonValue(bool truth)
            : this(JsonKind.Bool)
        {
            this.truth = truth;
        }

        private JsonValue(JsonNumber number)
            : this(JsonKind.Number)
        {
            this.number = number;
        }

        private JsonValue(List<JsonValue> items)
            : this(JsonKind.Array)
        {
            this.items = items;
        }

        private JsonValue(Dictionary<string, JsonValue> members)
            : this(JsonKind.Object)
        {
            this.members = members;
        }

        /// <summary>What it is.</summary>
        public JsonKind Kind { get; private set; }

        /// <summary>Whether it is null.</summary>
        public bool IsNull
        {
            get { return Kind == JsonKind.Null; }
        }

        /// <summary>The items of an array.</summary>
        public IReadOnlyList<JsonValue> Items
        {
            get
            {
                Need(JsonKind.Array);
                return items;
            }
        }

        /// <summary>The names of an object's members.</summary>
        public IEnumerable<string> Names
        {
            get
            {
                Need(JsonKind.Object);
                return members.Keys;
            }
        }

        /// <summary>An object's member.</summary>
        /// <exception cref="JsonFormatException">It has none of that name.</exception>
        public JsonValue this[string name]
        {
            get
            {
                Need(JsonKind.Object);
                JsonValue found;
                if (!members.TryGetValue(name, out found))
                {
                    throw new JsonFormatException("The answer has no '" + name + "'.");
                }
                return found;
            }
        }

        /// <summary>An object's member; null's value where it has none of that name.</summary>
        public JsonValue Find(string name)
        {
            JsonValue found;
            bool isThere = Kind == JsonKind.Object && members.TryGetValue(name, out found);
            return isThere ? members[name] : NullValue;
        }

        /// <summary>A string.</summary>
        public string AsString()
        {
            Need(JsonKind.String);
            return text;
        }

        /// <summary>A string, or null.</summary>
        public string AsStringOrNull()
        {
            return IsNull ? null : AsString();
        }

        /// <summary>true or false.</summary>
        public bool AsBool()
        {
            Need(JsonKind.Bool);
            return truth;
        }

        /// <summary>A number.</summary>
        public double AsDouble()
        {
            Need(JsonKind.Number);
            return number.Value;
        }

        /// <summary>A number, or null.</summary>
        public double? AsDoubleOrNull()
        {
            return IsNull ? (double?)null : AsDouble();
        }

        /// <summary>A whole number.</summary>
        public long AsLong()
        {
            Need(JsonKind.Number);
            if (!number.IsInteger)
            {
                throw new JsonFormatException("The answer has no whole number where one belongs.");
            }
            return number.Integer;
        }

        /// <summary>A whole number, or null.</summary>
        public long? AsLongOrNull()
        {
            return IsNull ? (long?)null : AsLong();
        }

        /// <summary>A text's tree.</summary>
        /// <param name="text">UTF-8.</param>
        /// <param name="count">How many of its bytes belong to it.</param>
        /// <exception cref="JsonFormatException">It is no JSON.</exception>
        public static JsonValue Parse(byte[] text, int count)
        {
            JsonReader reader = new JsonReader();
            reader.Reset(text, count);
            JsonValue value = Read(reader);
            reader.End();
            return value;
        }

        /// <summary>A text's tree.</summary>
        /// <exception cref="JsonFormatException">It is no JSON.</exception>
        public static JsonValue Parse(string text)
        {
            byte[] bytes = System.Text.Encoding.UTF8.GetBytes(text);
            return Parse(bytes, bytes.Length);
        }

        private static JsonValue Read(JsonReader reader)
        {
            switch (reader.Next())
            {
                case '{':
                    return ReadObject(reader);
                case '[':
                    return ReadArray(reader);
                case '"':
                    return new JsonValue(reader.ReadString());
                case 't':
                case 'f':
                    return new JsonValue(reader.ReadBool());
                case 'n':
                    reader.TakeNull();
                    return NullValue;
                default:
                    return new JsonValue(reader.ReadNumber());
            }
        }

        private static JsonValue ReadObject(JsonReader reader)
        {
            Dictionary<string, JsonValue> members = new Dictionary<string, JsonValue>();
            string name;
            reader.BeginObject();
            while (reader.NextName(out name))
            {
                members[name] = Read(reader);
            }
            return new JsonValue(members);
        }

        private static JsonValue ReadArray(JsonReader reader)
        {
            List<JsonValue> items = new List<JsonValue>();
            reader.BeginArray();
            while (reader.NextItem())
            {
                items.Add(Read(reader));
            }
            return new JsonValue(items);
        }

        private void Need(JsonKind kind)
        {
            if (Kind != kind)
            {
                throw new JsonFormatException(
                    "The answer has " + Kind + " where " + kind + " belongs.");
            }
        }
    }
}
