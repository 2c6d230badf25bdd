using System;
using System.Collections.Generic;
using System.Reflection;
using System.Text.RegularExpressions;

namespace Snapfit.Tests
{
    /// <summary>Runs the tests of assemblies whose names match a regular expression: runner.exe
    /// FOLDER EXPRESSION ASSEMBLY... A line a test, "ok" or "FAIL", and how many there were; exit
    /// code 1 where one failed.</summary>
    public static class Program
    {
        /// <summary>Runs them.</summary>
        public static int Main(string[] arguments)
        {
            TestList.Folder = arguments[0];
            int count = 0;
            int failed = 0;
            for (int place = 2; place < arguments.Length; place++)
            {
                Assembly assembly = Assembly.LoadFrom(arguments[place]);
                foreach (KeyValuePair<string, Action> test in TestList.In(assembly))
                {
                    if (Regex.IsMatch(test.Key, arguments[1]))
                    {
                        count++;
                        failed += Passes(test) ? 0 : 1;
                    }
                }
            }
            Console.WriteLine(count + " tests, " + failed + " failed");
            return failed == 0 && count > 0 ? 0 : 1;
        }

        private static bool Passes(KeyValuePair<string, Action> test)
        {
            try
            {
                test.Value();
                Console.WriteLine("ok " + test.Key);
                return true;
            }
            catch (Exception error)
            {
                Console.WriteLine("FAIL " + test.Key + ": " + error);
                return false;
            }
        }
    }
}
