using System;
using System.Collections.Generic;
using System.IO;
using NUnit.Framework;

namespace Snapfit.Tests
{
    /// <summary>Shows the tests in Unity's Test Runner (Window, General, Test Runner, EditMode).
    /// </summary>
    public sealed class UnityTestRunner
    {
        /// <summary>A test by its name.</summary>
        [TestCaseSource("Names")]
        public void Core(string name)
        {
            TestList.Folder = Path.GetFullPath("Packages/com.snapfit.client/Tests/Core");
            foreach (KeyValuePair<string, Action> test in TestList.In(typeof(TestList).Assembly))
            {
                if (test.Key == name)
                {
                    test.Value();
                    return;
                }
            }
            throw new ArgumentException("There is no test " + name);
        }

        /// <summary>The names of all.</summary>
        public static IEnumerable<string> Names()
        {
            foreach (KeyValuePair<string, Action> test in TestList.In(typeof(TestList).Assembly))
            {
                yield return test.Key;
            }
        }
    }
}
