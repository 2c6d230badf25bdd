using System;

namespace Snapfit
{
    /// <summary>The server does not answer: it is down, the network is, or the address is wrong.
    /// Worth trying again.</summary>
    public sealed class UnreachableException : SnapfitException
    {
        /// <summary>With what is wrong.</summary>
        public UnreachableException(string message)
            : base(message)
        {
        }

        /// <summary>With what is wrong, and its cause.</summary>
        public UnreachableException(string message, Exception cause)
            : base(message, cause)
        {
        }
    }
}
