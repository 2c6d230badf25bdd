using System;
using System.Collections.Generic;
using System.Diagnostics;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit.Tests
{
    /// <summary>The client against a real server: live.exe SCENARIO ADDRESS [KEY]. It says what it
    /// waits for on standard output, and is told on standard input when that has happened; exit
    /// code 1 where something does not hold.</summary>
    public static class Live
    {
        private static readonly Dictionary<string, Action<SnapfitOptions>> Scenarios =
            new Dictionary<string, Action<SnapfitOptions>>
            {
                { "requests", RequestScenarios.Requests },
                { "refusals", RequestScenarios.Refusals },
                { "commands", RequestScenarios.Commands },
                { "stream", StreamScenarios.Stream },
                { "restart", StreamScenarios.Restart },
                { "fallback", StreamScenarios.Fallback },
                { "frozen", StreamScenarios.Frozen },
                { "keys", StreamScenarios.Keys },
                { "events", StreamScenarios.Events },
                { "world", WorldScenarios.World },
                { "guide", WorldScenarios.Guide },
            };

        private const double Patience = 4;

        /// <summary>Runs a scenario.</summary>
        public static int Main(string[] arguments)
        {
            SnapfitOptions options = new SnapfitOptions(arguments[1])
            {
                ApiKey = arguments.Length > 2 ? arguments[2] : null,
            };
            try
            {
                Scenarios[arguments[0]](options);
            }
            catch (Exception error)
            {
                Console.WriteLine("FAIL " + error);
                return 1;
            }
            Console.WriteLine("passed");
            return 0;
        }

        /// <summary>Wait for something that others do.</summary>
        public static void Ask(string what)
        {
            Console.WriteLine(what);
            Check.Equal("done", Console.ReadLine(), what);
        }

        /// <summary>Wait until it holds; the limit is for a machine that has nothing else to do.
        /// </summary>
        public static void Until(Func<bool> holds, double limitS, string what)
        {
            limitS *= Patience;
            Stopwatch watch = Stopwatch.StartNew();
            while (!holds())
            {
                Check.That(watch.Elapsed.TotalSeconds < limitS, "within " + limitS + " s: " + what);
                Thread.Sleep(5);
            }
        }

        /// <summary>The result of a request.</summary>
        public static T Get<T>(Func<CancellationToken, Task<T>> request)
        {
            return request(CancellationToken.None).GetAwaiter().GetResult();
        }

        /// <summary>The problem that a request meets.</summary>
        public static ProblemException ProblemOf<T>(Func<CancellationToken, Task<T>> request)
        {
            try
            {
                Get(request);
            }
            catch (ProblemException problem)
            {
                return problem;
            }
            throw new Exception("Nothing was refused.");
        }
    }
}
