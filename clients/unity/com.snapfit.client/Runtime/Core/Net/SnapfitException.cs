using System;

namespace Snapfit
{
    /// <summary>Whatever goes wrong between this client and its server.</summary>
    public class SnapfitException : Exception
    {
        /// <summary>With what is wrong.</summary>
        public SnapfitException(string message)
            : base(message)
        {
        }

        /// <summary>With what is wrong, and its cause.</summary>
        public SnapfitException(string message, Exception cause)
            : base(message, cause)
        {
        }
    }
}
