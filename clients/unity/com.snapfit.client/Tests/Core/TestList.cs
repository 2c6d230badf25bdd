using System;
using System.Collections.Generic;
using System.Reflection;

namespace Snapfit.Tests
{
    /// <summary>All tests: public static methods without arguments in classes whose names end with
    /// Tests.</summary>
    public static class TestList
    {
        /// <summary>Where the package's Tests/Core folder is.</summary>
        public static string Folder { get; set; }

        /// <summary>Those of an assembly, sorted by name.</summary>
        public static List<KeyValuePair<string, Action>> In(Assembly assembly)
        {
            List<KeyValuePair<string, Action>> found = new List<KeyValuePair<string, Action>>();
            foreach (Type type in assembly.GetTypes())
            {
                if (!type.Name.EndsWith("Tests"))
                {
                    continue;
                }
                foreach (MethodInfo method in type.GetMethods(
                    BindingFlags.Public | BindingFlags.Static | BindingFlags.DeclaredOnly))
                {
                    if (method.GetParameters().Length == 0 && method.ReturnType == typeof(void))
                    {
                        Action run = (Action)Delegate.CreateDelegate(typeof(Action), method);
                        found.Add(new KeyValuePair<string, Action>(
                            type.Name + "." + method.Name, run));
                    }
                }
            }
            found.Sort((a, b) => string.CompareOrdinal(a.Key, b.Key));
            return found;
        }
    }
}
