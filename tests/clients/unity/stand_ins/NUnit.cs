using System;

namespace NUnit.Framework
{
    /// <summary>As much of NUnit as the package names.</summary>
    [AttributeUsage(AttributeTargets.Method)]
    public sealed class TestCaseSourceAttribute : Attribute
    {
        /// <summary>A member that gives the cases.</summary>
        public TestCaseSourceAttribute(string sourceName)
        {
            SourceName = sourceName;
        }

        /// <summary>Its name.</summary>
        public string SourceName { get; private set; }
    }
}
