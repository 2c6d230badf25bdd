using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>The server said no, by problem details (RFC 9457).</summary>
    public sealed class ProblemException : SnapfitException
    {
        private const string Prefix = "urn:snapfit:problem:";

        private ProblemException(int status, JsonValue body, double? retryAfterS)
            : base(Text(body, "title") + ": " + Text(body, "detail"))
        {
            Status = status;
            Type = body.Find("type").AsStringOrNull() ?? "about:blank";
            Title = Text(body, "title");
            Detail = Text(body, "detail");
            Instance = Text(body, "instance");
            RetryAfterS = retryAfterS;
            Body = body;
        }

        private ProblemException(int status, string message, double? retryAfterS)
            : base(message)
        {
            Status = status;
            Type = "about:blank";
            Title = "HTTP " + status;
            Detail = message;
            Instance = "";
            RetryAfterS = retryAfterS;
            Body = JsonValue.Parse("{}");
        }

        /// <summary>The HTTP status.</summary>
        public int Status { get; private set; }

        /// <summary>Which kind of problem, an URN.</summary>
        public string Type { get; private set; }

        /// <summary>The status in words.</summary>
        public string Title { get; private set; }

        /// <summary>What is wrong and what to do.</summary>
        public string Detail { get; private set; }

        /// <summary>The path that was asked for.</summary>
        public string Instance { get; private set; }

        /// <summary>When to ask again, seconds; null where the server did not say.</summary>
        public double? RetryAfterS { get; private set; }

        /// <summary>All of it: further members tell, for example, the parts that there are.
        /// </summary>
        public JsonValue Body { get; private set; }

        /// <summary>The kind without what all kinds begin with, such as unknown-part.</summary>
        public string Kind
        {
            get { return Type.StartsWith(Prefix) ? Type.Substring(Prefix.Length) : Type; }
        }

        /// <summary>Names that the server lists, such as "parts"; none where it does not.
        /// </summary>
        public IReadOnlyList<string> Names(string member)
        {
            return JsonLists.StringsOrNone(Body.Find(member));
        }

        /// <summary>From an answer whose status says that something is wrong.</summary>
        public static ProblemException From(int status, byte[] body, int count, double? retryAfterS)
        {
            try
            {
                return new ProblemException(status, JsonValue.Parse(body, count), retryAfterS);
            }
            catch (JsonFormatException)
            {
                // Not snapfit's: a proxy, or another server.
                return new ProblemException(
                    status, "The answer is HTTP status " + status + " without a reason. Does "
                    + "snapfit answer at this address?", retryAfterS);
            }
        }

        private static string Text(JsonValue body, string name)
        {
            return body.Find(name).AsStringOrNull() ?? "";
        }
    }
}
