using System;

namespace Snapfit
{
    /// <summary>How snapshots come.</summary>
    public enum Transport
    {
        /// <summary>WebSocket; long poll where there is none.</summary>
        Auto,

        /// <summary>WebSocket and nothing else.</summary>
        WebSocket,

        /// <summary>A request is answered when there is something new.</summary>
        LongPoll,

        /// <summary>Asked for at a fixed rate; answered by 304 while nothing is new.</summary>
        Poll,
    }

    /// <summary>Where the server is, and what is asked of it. Not to be changed once a client has
    /// it.</summary>
    public sealed class SnapfitOptions
    {
        /// <summary>For a server's address.</summary>
        /// <param name="address">Such as http://192.168.1.20:8000.</param>
        /// <exception cref="ArgumentException">It is none.</exception>
        public SnapfitOptions(string address)
        {
            Uri uri;
            bool isUri = Uri.TryCreate(address, UriKind.Absolute, out uri);
            if (!isUri || (uri.Scheme != "http" && uri.Scheme != "https"))
            {
                throw new ArgumentException("'" + address + "' is no address of a server; "
                    + "write it like http://192.168.1.20:8000.", "address");
            }
            Address = new Uri(uri.GetLeftPart(UriPartial.Authority));
        }

        /// <summary>Scheme, host and port.</summary>
        public Uri Address { get; private set; }

        /// <summary>The workbench; null for a server's only one.</summary>
        public string Station { get; set; }

        /// <summary>The API key; null where the server needs none.</summary>
        public string ApiKey { get; set; }

        /// <summary>The frame of poses: camera, or anchor:ID.</summary>
        public string Frame { get; set; } = "camera";

        /// <summary>The axes of poses.</summary>
        public Convention Convention { get; set; } = Convention.Unity;

        /// <summary>How snapshots come.</summary>
        public Transport Transport { get; set; } = Transport.Auto;

        /// <summary>How often <see cref="Transport.Poll"/> asks, hertz.</summary>
        public double PollHz { get; set; } = 30;

        /// <summary>How long a long poll waits, seconds, at most 60.</summary>
        public double LongPollS { get; set; } = 20;

        /// <summary>How long an answer may take, beside what a long poll waits, seconds.
        /// </summary>
        public double TimeoutS { get; set; } = 5;

        /// <summary>The first wait before it is tried again, seconds.</summary>
        public double FirstRetryS { get; set; } = 0.25;

        /// <summary>The longest wait before it is tried again, seconds.</summary>
        public double LongestRetryS { get; set; } = 10;

        /// <summary>The path of what belongs to the station.</summary>
        /// <param name="below">Such as /poses.</param>
        public string StationPath(string below)
        {
            bool isOnly = string.IsNullOrEmpty(Station);
            return (isOnly ? "/v1" : "/v1/stations/" + Uri.EscapeDataString(Station)) + below;
        }

        /// <summary>Frame and convention as a query.</summary>
        public string ViewQuery
        {
            get
            {
                return "?convention=" + Convention.Name() + "&frame="
                    + Uri.EscapeDataString(Frame);
            }
        }
    }
}
