using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>Gives the same string for the same bytes, so that names which come with every
    /// snapshot are made once. ASCII alone, and bounded: what is beyond is left to the caller.
    /// </summary>
    public sealed class JsonStrings
    {
        /// <summary>Longer strings are not kept.</summary>
        public const int MaxLength = 96;

        private const int MaxCount = 1024;
        private const ulong FnvOffset = 14695981039346656037;
        private const ulong FnvPrime = 1099511628211;

        private readonly Dictionary<ulong, string> known = new Dictionary<ulong, string>();

        /// <summary>The string of these bytes; null if it is not kept here (not ASCII, long, or
        /// one too many).</summary>
        public string Find(byte[] bytes, int start, int length)
        {
            if (length > MaxLength)
            {
                return null;
            }
            ulong hash = FnvOffset;
            for (int place = start; place < start + length; place++)
            {
                if (bytes[place] >= 0x80)
                {
                    return null;
                }
                hash = unchecked((hash ^ bytes[place]) * FnvPrime);
            }
            string found;
            if (known.TryGetValue(hash, out found))
            {
                return IsSame(found, bytes, start, length) ? found : null;
            }
            if (known.Count >= MaxCount)
            {
                return null;
            }
            found = System.Text.Encoding.ASCII.GetString(bytes, start, length);
            known.Add(hash, found);
            return found;
        }

        private static bool IsSame(string text, byte[] bytes, int start, int length)
        {
            if (text.Length != length)
            {
                return false;
            }
            for (int place = 0; place < length; place++)
            {
                if (text[place] != bytes[start + place])
                {
                    return false;
                }
            }
            return true;
        }
    }
}
