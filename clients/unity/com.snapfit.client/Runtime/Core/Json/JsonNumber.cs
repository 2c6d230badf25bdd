using System;

namespace Snapfit
{
    /// <summary>A number of a JSON text, read without making a string of it.</summary>
    public readonly struct JsonNumber
    {
        private static readonly double[] PowersOfTen =
        {
            1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
            1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
        };

        private readonly long digits;
        private readonly int exponent;
        private readonly bool isNegative;

        private JsonNumber(long digits, int exponent, bool isNegative)
        {
            this.digits = digits;
            this.exponent = exponent;
            this.isNegative = isNegative;
        }

        /// <summary>Whether it is a whole number that fits a long.</summary>
        public bool IsInteger
        {
            get { return exponent == 0; }
        }

        /// <summary>Exact, where it is an integer.</summary>
        public long Integer
        {
            get { return isNegative ? -digits : digits; }
        }

        /// <summary>Exact to 15 digits and 22 decimal places, as all of the server's poses in the
        /// camera's frame; some units in the last place off beyond that.</summary>
        public double Value
        {
            get
            {
                double size = digits;
                int power = Math.Abs(exponent);
                if (power < PowersOfTen.Length)
                {
                    size = exponent < 0 ? size / PowersOfTen[power] : size * PowersOfTen[power];
                }
                else if (size != 0)
                {
                    size *= Math.Pow(10, exponent);
                }
                return isNegative ? -size : size;
            }
        }

        /// <summary>Reads a number by JSON's grammar.</summary>
        /// <param name="bytes">The text, UTF-8.</param>
        /// <param name="place">Where it begins; then the first byte behind it.</param>
        /// <param name="end">The end of the text.</param>
        /// <exception cref="JsonFormatException">There is no number.</exception>
        public static JsonNumber Read(byte[] bytes, ref int place, int end)
        {
            int start = place;
            bool isNegative = place < end && bytes[place] == '-';
            place += isNegative ? 1 : 0;
            int first = place;
            long digits = 0;
            int exponent = 0;
            int count = Digits(bytes, ref place, end, ref digits, ref exponent, false);
            bool isWrong = count == 0 || (count > 1 && bytes[first] == '0');
            if (!isWrong && place < end && bytes[place] == '.')
            {
                place++;
                isWrong = Digits(bytes, ref place, end, ref digits, ref exponent, true) == 0;
            }
            if (!isWrong && place < end && (bytes[place] == 'e' || bytes[place] == 'E'))
            {
                isWrong = !Exponent(bytes, ref place, end, ref exponent);
            }
            if (isWrong)
            {
                throw new JsonFormatException("There is no JSON number at byte " + start + ".");
            }
            return new JsonNumber(digits, exponent, isNegative);
        }

        private static int Digits(
            byte[] bytes, ref int place, int end, ref long digits, ref int exponent, bool behind)
        {
            int start = place;
            for (; place < end && bytes[place] >= '0' && bytes[place] <= '9'; place++)
            {
                // Digits beyond what a double holds are dropped, their power of ten is kept.
                bool isKept = digits < 100000000000000000L;
                digits = isKept ? 10 * digits + (bytes[place] - '0') : digits;
                exponent += (isKept ? 0 : 1) - (behind ? 1 : 0);
            }
            return place - start;
        }

        private static bool Exponent(byte[] bytes, ref int place, int end, ref int exponent)
        {
            place++;
            bool isDown = place < end && bytes[place] == '-';
            if (isDown || (place < end && bytes[place] == '+'))
            {
                place++;
            }
            int start = place;
            int told = 0;
            for (; place < end && bytes[place] >= '0' && bytes[place] <= '9'; place++)
            {
                told = Math.Min(10 * told + (bytes[place] - '0'), 100000);
            }
            exponent += isDown ? -told : told;
            return place > start;
        }
    }
}
