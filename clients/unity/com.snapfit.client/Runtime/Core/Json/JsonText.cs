using System;
using System.Text;

namespace Snapfit
{
    /// <summary>JSON strings: from their bytes, and back.</summary>
    internal static class JsonText
    {
        private const string Escapes = "\"\\/bfnrt";
        private const string Meanings = "\"\\/\b\f\n\r\t";
        private static readonly UTF8Encoding Strict = new UTF8Encoding(false, true);

        /// <summary>The text between the quotes, its escapes undone.</summary>
        /// <exception cref="JsonFormatException">A wrong escape, or no UTF-8.</exception>
        public static string Decode(byte[] bytes, int start, int length)
        {
            string raw;
            try
            {
                raw = Strict.GetString(bytes, start, length);
            }
            catch (ArgumentException error)
            {
                throw new JsonFormatException(
                    "A string at byte " + start + " is not UTF-8.", error);
            }
            if (raw.IndexOf('\\') < 0)
            {
                return raw;
            }
            StringBuilder text = new StringBuilder(raw.Length);
            for (int place = 0; place < raw.Length; place++)
            {
                text.Append(raw[place] == '\\' ? Unescape(raw, ref place) : raw[place]);
            }
            return text.ToString();
        }

        /// <summary>With quotes and escapes, at the end of a text.</summary>
        public static void Append(StringBuilder json, string text)
        {
            json.Append('"');
            foreach (char letter in text)
            {
                int escape = letter == '/' ? -1 : Meanings.IndexOf(letter);
                if (escape >= 0)
                {
                    json.Append('\\').Append(Escapes[escape]);
                }
                else if (letter < ' ')
                {
                    json.Append("\\u").Append(((int)letter).ToString("x4"));
                }
                else
                {
                    json.Append(letter);
                }
            }
            json.Append('"');
        }

        private static char Unescape(string raw, ref int place)
        {
            place++;
            char kind = place < raw.Length ? raw[place] : ' ';
            int simple = Escapes.IndexOf(kind);
            if (simple >= 0)
            {
                return Meanings[simple];
            }
            ushort code = 0;
            bool isCode = kind == 'u' && place + 4 < raw.Length && ushort.TryParse(
                raw.Substring(place + 1, 4), System.Globalization.NumberStyles.AllowHexSpecifier,
                System.Globalization.CultureInfo.InvariantCulture, out code);
            if (!isCode)
            {
                throw new JsonFormatException("A string has the wrong escape '\\" + kind + "'.");
            }
            place += 4;
            return (char)code;
        }
    }
}
