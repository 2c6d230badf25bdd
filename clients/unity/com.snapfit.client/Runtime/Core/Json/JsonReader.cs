using System;

namespace Snapfit
{
    /// <summary>Reads a JSON text (RFC 8259, UTF-8) from front to back, by what the caller expects
    /// next. It makes no objects beside strings that it has not met before, and uses no
    /// reflection, so it does under IL2CPP what it does elsewhere.</summary>
    /// <example><code>
    /// reader.BeginObject();
    /// while (reader.NextName(out name))
    /// {
    ///     if (name == "seq") seq = reader.ReadLong(); else reader.Skip();
    /// }
    /// </code></example>
    public sealed class JsonReader
    {
        private const int MaxDepth = 64;

        private readonly JsonStrings strings = new JsonStrings();
        private readonly bool[] isFirst = new bool[MaxDepth + 1];
        private byte[] bytes = new byte[0];
        private int place;
        private int end;
        private int depth;

        /// <summary>Begin with a text.</summary>
        /// <param name="text">UTF-8; it must not change while it is read.</param>
        /// <param name="count">How many of its bytes belong to the text.</param>
        public void Reset(byte[] text, int count)
        {
            bytes = text;
            place = 0;
            end = count;
            depth = 0;
        }

        /// <summary>Whether a null comes next; it is taken then.</summary>
        public bool TakeNull()
        {
            if (Peek() != (byte)'n')
            {
                return false;
            }
            Literal("null");
            return true;
        }

        /// <summary>What comes next: one of { [ " t f n - 0, the last for every digit.</summary>
        public char Next()
        {
            byte next = Peek();
            return next >= '1' && next <= '9' ? '0' : (char)next;
        }

        /// <summary>Go into an object.</summary>
        public void BeginObject()
        {
            Begin((byte)'{');
        }

        /// <summary>Go into an array.</summary>
        public void BeginArray()
        {
            Begin((byte)'[');
        }

        /// <summary>The name of an object's next member; false at its end.</summary>
        public bool NextName(out string name)
        {
            name = null;
            if (!Continue((byte)'}'))
            {
                return false;
            }
            name = ReadString();
            Take((byte)':');
            return true;
        }

        /// <summary>Whether the array has another item; false at its end.</summary>
        public bool NextItem()
        {
            return Continue((byte)']');
        }

        /// <summary>A string.</summary>
        public string ReadString()
        {
            if (Peek() != (byte)'"')
            {
                throw Wrong("a string");
            }
            place++;
            int start = place;
            bool isPlain = true;
            for (; place < end && bytes[place] != '"'; place++)
            {
                if (bytes[place] < 0x20)
                {
                    throw Wrong("no control character in a string");
                }
                if (bytes[place] == '\\')
                {
                    isPlain = false;
                    place++;
                }
            }
            if (place >= end)
            {
                throw Wrong("the end of a string");
            }
            int length = place - start;
            place++;
            string known = isPlain ? strings.Find(bytes, start, length) : null;
            return known ?? JsonText.Decode(bytes, start, length);
        }

        /// <summary>A number.</summary>
        public JsonNumber ReadNumber()
        {
            Peek();
            return JsonNumber.Read(bytes, ref place, end);
        }

        /// <summary>A number as a double.</summary>
        public double ReadDouble()
        {
            return ReadNumber().Value;
        }

        /// <summary>A whole number.</summary>
        public long ReadLong()
        {
            JsonNumber number = ReadNumber();
            if (!number.IsInteger)
            {
                throw Wrong("a whole number");
            }
            return number.Integer;
        }

        /// <summary>true or false.</summary>
        public bool ReadBool()
        {
            bool value = Peek() == (byte)'t';
            Literal(value ? "true" : "false");
            return value;
        }

        /// <summary>Past a value of any kind.</summary>
        public void Skip()
        {
            switch (Next())
            {
                case '{':
                    BeginObject();
                    string name;
                    while (NextName(out name))
                    {
                        Skip();
                    }
                    break;
                case '[':
                    BeginArray();
                    while (NextItem())
                    {
                        Skip();
                    }
                    break;
                case '"':
                    ReadString();
                    break;
                case 't':
                case 'f':
                    ReadBool();
                    break;
                case 'n':
                    Literal("null");
                    break;
                default:
                    ReadNumber();
                    break;
            }
        }

        /// <summary>The text ends here.</summary>
        public void End()
        {
            SkipSpace();
            if (place != end)
            {
                throw Wrong("the end");
            }
        }

        private void Begin(byte bracket)
        {
            Take(bracket);
            if (++depth > MaxDepth)
            {
                throw Wrong("no more than " + MaxDepth + " levels");
            }
            isFirst[depth] = true;
        }

        private bool Continue(byte bracket)
        {
            if (Peek() == bracket)
            {
                place++;
                depth--;
                return false;
            }
            if (!isFirst[depth])
            {
                Take((byte)',');
            }
            isFirst[depth] = false;
            return true;
        }

        private void Literal(string word)
        {
            Peek();
            for (int letter = 0; letter < word.Length; letter++)
            {
                if (place + letter >= end || bytes[place + letter] != word[letter])
                {
                    throw Wrong(word);
                }
            }
            place += word.Length;
        }

        private void Take(byte wanted)
        {
            if (Peek() != wanted)
            {
                throw Wrong("'" + (char)wanted + "'");
            }
            place++;
        }

        private byte Peek()
        {
            SkipSpace();
            if (place >= end)
            {
                throw Wrong("more");
            }
            return bytes[place];
        }

        private void SkipSpace()
        {
            while (place < end && (bytes[place] == ' ' || bytes[place] == '\n'
                || bytes[place] == '\r' || bytes[place] == '\t'))
            {
                place++;
            }
        }

        private JsonFormatException Wrong(string expected)
        {
            return new JsonFormatException(
                "The answer is not the JSON of the contract: expected " + expected + " at byte "
                + Math.Min(place, end) + " of " + end + ".");
        }
    }
}
