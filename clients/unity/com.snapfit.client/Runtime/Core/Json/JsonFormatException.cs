using System;

namespace Snapfit
{
    /// <summary>An answer is not what the contract says: no JSON, or something is missing in it.
    /// Most often something else than snapfit answers at that address.</summary>
    public sealed class JsonFormatException : SnapfitException
    {
        /// <summary>With what is wrong.</summary>
        public JsonFormatException(string message)
            : base(message)
        {
        }

        /// <summary>With what is wrong, and its cause.</summary>
        public JsonFormatException(string message, Exception cause)
            : base(message, cause)
        {
        }
    }
}
