using System;
using System.Collections.Generic;
using System.Globalization;
using System.Text;

namespace Snapfit.Tests
{
    /// <summary>JSON: what is read is what was written, and what is none is refused.</summary>
    public static class JsonTests
    {
        private static readonly string[] Wrong =
        {
            "", " ", "{", "[1,]", "[1 2]", "{\"a\" 1}", "{\"a\":1,}", "{a:1}", "[1]x", "\"abc",
            "\"a\nb\"", "\"\\x\"", "\"\\u12g4\"", "\"\\u12\"", "01", "-", "1.", ".5", "1e", "+1",
            "tru", "nul", "NaN", "Infinity", "[,1]", "}", "'a'",
        };

        // By Python's float() and struct.
        private static readonly Dictionary<string, long> Nearest = new Dictionary<string, long>
        {
            { "4.13355342537796", 4616339985843949958L },
            { "0.1", 4591870180066957722L },
            { "-0.060458258", -4634498262596572758L },
            { "0.79800636", 4605363021836346988L },
            { "0.00006237546", 4544230920977859597L },
            { "6.237546e-5", 4544230920977859597L },
            { "1795366685452300", 4835040267282980912L },
            { "1e22", 4936209963552724370L },
            { "-0.0", -9223372036854775808L },
            { "2.5e-3", 4567911030049346683L },
            { "-7.31271512e-05", -4678347781093212391L },
            { "-48.9861949", -4591281025510965838L },
            { "52.192489", 4632542257122372477L },
            { "0.00303185945", 4569137414444013423L },
            { "-8.12280826e-06", -4692459551663202240L },
            { "7.86634085", 4620542730857595232L },
        };

        /// <summary>All kinds of values, nested.</summary>
        public static void ReadsEveryKind()
        {
            JsonValue json = JsonValue.Parse(
                " {\"a\": [1, -2.5e-3, true, false, null, \"x\"], \"b\": {}, \"c\" : [] } ");
            Check.Equal(6, json["a"].Items.Count);
            Check.Equal(1L, json["a"].Items[0].AsLong());
            Check.Near(-0.0025, json["a"].Items[1].AsDouble(), 0, "number");
            Check.That(json["a"].Items[2].AsBool() && !json["a"].Items[3].AsBool(), "bools");
            Check.That(json["a"].Items[4].IsNull, "null");
            Check.Equal("x", json["a"].Items[5].AsString());
            Check.Equal(JsonKind.Object, json["b"].Kind);
            Check.Equal(0, json["c"].Items.Count);
        }

        /// <summary>Escapes, umlauts, and what lies beyond 16 bits.</summary>
        public static void UndoesEscapes()
        {
            string text = JsonValue.Parse(
                "\"\\\"\\\\\\/\\b\\f\\n\\r\\t \\u00e4 ä \\ud83d\\ude00 😀\"")
                .AsString();
            Check.Equal("\"\\/\b\f\n\r\t ä ä 😀 😀", text);
        }

        /// <summary>Whatever is no JSON.</summary>
        public static void RefusesWhatIsNone()
        {
            foreach (string text in Wrong)
            {
                try
                {
                    JsonValue.Parse(text);
                }
                catch (JsonFormatException)
                {
                    continue;
                }
                throw new Exception("Was taken for JSON: " + text);
            }
        }

        /// <summary>Bytes that are not UTF-8.</summary>
        public static void RefusesOtherEncodings()
        {
            byte[] latin = { (byte)'"', 0xe4, (byte)'"' };
            Check.Throws<JsonFormatException>(() => JsonValue.Parse(latin, 3), "UTF-8");
        }

        /// <summary>Nesting that would fill the stack.</summary>
        public static void RefusesDeepNesting()
        {
            string deep = new string('[', 100000);
            Check.Throws<JsonFormatException>(() => JsonValue.Parse(deep), "64 levels");
        }

        /// <summary>Exactly the nearest double, as another language's parser finds it.</summary>
        public static void ReadsShortNumbersExactly()
        {
            foreach (KeyValuePair<string, long> each in Nearest)
            {
                double read = JsonValue.Parse(each.Key).AsDouble();
                Check.Equal(each.Value, BitConverter.DoubleToInt64Bits(read), each.Key);
            }
        }

        /// <summary>Against .NET's own parser, which in Mono is a unit in the last place off now
        /// and then.</summary>
        public static void ReadsNumbersAsDotNetDoes()
        {
            Random random = new Random(7);
            for (int turn = 0; turn < 5000; turn++)
            {
                double value = (random.NextDouble() - 0.5) * Math.Pow(10, random.Next(-15, 16));
                foreach (string format in new[] { "G9", "G15", "R", "E16", "E25" })
                {
                    string text = value.ToString(format, CultureInfo.InvariantCulture);
                    double wanted = double.Parse(text, CultureInfo.InvariantCulture);
                    double read = JsonValue.Parse(text).AsDouble();
                    Check.Near(wanted, read, 7e-16 * Math.Abs(wanted), text);
                }
            }
        }

        /// <summary>Time stamps need all their digits.</summary>
        public static void ReadsTimeStampsExactly()
        {
            Check.Equal(1795366685452301L, JsonValue.Parse("1795366685452301").AsLong());
            Check.Equal(-9007199254740993L, JsonValue.Parse("-9007199254740993").AsLong());
            Check.Throws<JsonFormatException>(
                () => JsonValue.Parse("1.5").AsLong(), "whole number");
        }

        /// <summary>Names that come again are the same object.</summary>
        public static void KeepsNames()
        {
            byte[] text = Encoding.UTF8.GetBytes("[\"station\",\"station\"]");
            JsonReader reader = new JsonReader();
            reader.Reset(text, text.Length);
            reader.BeginArray();
            reader.NextItem();
            string first = reader.ReadString();
            reader.NextItem();
            Check.That(ReferenceEquals(first, reader.ReadString()), "one object");
        }

        /// <summary>A missing member is told by its name, a wrong kind by both.</summary>
        public static void TellsWhatIsMissing()
        {
            JsonValue json = JsonValue.Parse("{\"a\":1}");
            Check.Throws<JsonFormatException>(() => json["seq"].AsLong(), "'seq'");
            Check.Throws<JsonFormatException>(() => json["a"].AsString(), "Number where String");
            Check.That(json.Find("seq").IsNull, "found as null");
        }

        /// <summary>What is written is read again.</summary>
        public static void WritesWhatItReads()
        {
            string text = new JsonWriter().BeginObject()
                .Member("s", "a\"b\\c\n\u0001ä").Member("d", 0.1).Member("t", true)
                .Member("n", new[] { 1.5, -2e-9 }).Member("w", new[] { "x", "y" })
                .BeginObject("o").EndObject().Member("p", RigidPose.Identity)
                .EndObject().ToString();
            JsonValue json = JsonValue.Parse(text);
            Check.Equal("a\"b\\c\n\u0001ä", json["s"].AsString());
            Check.Near(0.1, json["d"].AsDouble(), 0, "d");
            Check.Near(-2e-9, json["n"].Items[1].AsDouble(), 0, "n");
            Check.Equal("y", json["w"].Items[1].AsString());
            Check.Near(1, json["p"]["orientation"].Items[3].AsDouble(), 0, "w of p");
            Check.Throws<ArgumentException>(
                () => new JsonWriter().BeginObject().Member("d", double.NaN), "no number");
        }
    }
}
