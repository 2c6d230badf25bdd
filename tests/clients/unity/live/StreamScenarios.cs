using System;
using System.Collections.Generic;
using System.Threading;

namespace Snapfit.Tests
{
    /// <summary>What goes on: poses and events, through restarts, proxies and dead connections.
    /// </summary>
    public static class StreamScenarios
    {
        private const double VelocityMPerS = 0.1;
        private const int Followed = 40;

        /// <summary>Every transport: in order, on the server's time line, and the jaw is shown
        /// where it is.</summary>
        public static void Stream(SnapfitOptions options)
        {
            foreach (Transport transport in new[]
                { Transport.Auto, Transport.WebSocket, Transport.LongPoll, Transport.Poll })
            {
                options.Transport = transport;
                using (SnapfitClient client = new SnapfitClient(options))
                using (PoseFeed feed = new PoseFeed(options, client))
                {
                    feed.Start();
                    Follow(feed, transport);
                    Transport wanted = transport == Transport.Auto
                        ? Transport.WebSocket : transport;
                    Check.Equal(wanted, feed.TransportInUse);
                    feed.Dispose();
                    Check.That(feed.Ended.Wait(30000), transport + " ends when told to");
                    Check.Equal(FeedState.Stopped, feed.State);
                }
            }
        }

        /// <summary>The worker dies, then the server; clients by WebSocket and by long poll come
        /// back by themselves.</summary>
        public static void Restart(SnapfitOptions options)
        {
            options.LongestRetryS = 1;
            SnapfitOptions other = new SnapfitOptions(options.Address.ToString())
            {
                Transport = Transport.LongPoll, LongestRetryS = 1,
            };
            using (SnapfitClient client = new SnapfitClient(options))
            using (SnapfitClient second = new SnapfitClient(other))
            using (PoseFeed stream = new PoseFeed(options, client))
            using (PoseFeed longPoll = new PoseFeed(other, second))
            {
                PoseFeed[] feeds = { stream, longPoll };
                PosePlayer[] players = { new PosePlayer(), new PosePlayer() };
                stream.Start();
                longPoll.Start();
                Live.Until(() => Play(feeds, players, 0), 30, "fresh poses");
                Live.Ask("kill the worker");
                Live.Until(() => Play(feeds, players, 1), 60, "poses of another worker");
                Live.Ask("stop the server");
                for (int place = 0; place < feeds.Length; place++)
                {
                    PoseFeed feed = feeds[place];
                    Live.Until(() => feed.State == FeedState.Reconnecting, 30, "notices");
                    PosePlayer player = players[place];
                    Live.Until(() => player.IsStale(feed.ServerNowUs), 30, "stale by silence");
                    Check.That(feed.LastError is UnreachableException, "" + feed.LastError);
                }
                Live.Ask("start the server");
                Live.Until(() => Play(feeds, players, 2), 60, "comes back");
                Follow(stream, Transport.WebSocket);
                Follow(longPoll, Transport.LongPoll);
                Check.Equal(Transport.WebSocket, stream.TransportInUse, "as before");
            }
        }

        /// <summary>A proxy that lets no WebSocket through: long poll takes its place.</summary>
        public static void Fallback(SnapfitOptions options)
        {
            using (SnapfitClient client = new SnapfitClient(options))
            using (PoseFeed feed = new PoseFeed(options, client))
            {
                feed.Start();
                Live.Until(() => feed.Received > 10, 30, "poses");
                Check.Equal(Transport.LongPoll, feed.TransportInUse);
            }
            options.Transport = Transport.WebSocket;
            using (SnapfitClient client = new SnapfitClient(options))
            using (PoseFeed feed = new PoseFeed(options, client))
            {
                feed.Start();
                Live.Until(() => feed.LastError != null, 30, "says why");
                Check.That(feed.LastError.Message.Contains("WebSocket"), feed.LastError.Message);
                Check.Equal(0L, feed.Received, "received");
            }
        }

        /// <summary>A connection that is dead without anybody having said so.</summary>
        public static void Frozen(SnapfitOptions options)
        {
            options.Transport = Transport.WebSocket;
            using (SnapfitClient client = new SnapfitClient(options))
            using (PoseFeed feed = new PoseFeed(options, client))
            {
                feed.Start();
                Live.Until(() => feed.Received > 10, 30, "poses");
                Live.Ask("freeze");
                Thread.Sleep(500);
                long frozen = feed.Received;
                Live.Until(() => feed.Received > frozen + 10, 30, "another connection");
                Check.That(feed.LastError is UnreachableException, "" + feed.LastError);
            }
        }

        /// <summary>Without the key it is refused and says why; with it all transports work.
        /// </summary>
        public static void Keys(SnapfitOptions options)
        {
            string key = options.ApiKey;
            options.ApiKey = null;
            using (SnapfitClient client = new SnapfitClient(options))
            using (PoseFeed feed = new PoseFeed(options, client))
            {
                feed.Start();
                Live.Until(() => feed.State == FeedState.Refused, 30, "refused");
                ProblemException problem = (ProblemException)feed.LastError;
                Check.Equal("key-needed", problem.Kind);
                Check.Equal(401, problem.Status);
            }
            options.ApiKey = key;
            using (SnapfitClient client = new SnapfitClient(options))
            {
                foreach (Transport transport in new[]
                    { Transport.WebSocket, Transport.LongPoll, Transport.Poll })
                {
                    options.Transport = transport;
                    using (PoseFeed feed = new PoseFeed(options, client))
                    {
                        feed.Start();
                        Live.Until(() => feed.Received > 10, 30, transport + " with the key");
                    }
                }
                Check.Equal("role-needed", Live.ProblemOf(
                    token => client.SetStateAsync("free", token)).Kind, "a key to read with");
            }
        }

        /// <summary>Events beside poses and requests; after a break what was missed comes.
        /// </summary>
        public static void Events(SnapfitOptions options)
        {
            options.Transport = Transport.LongPoll;
            using (SnapfitClient client = new SnapfitClient(options))
            using (PoseFeed feed = new PoseFeed(options, client))
            using (EventFeed events = new EventFeed(options, client))
            {
                feed.Start();
                events.Start();
                List<SnapfitEvent> got = new List<SnapfitEvent>();
                Live.Until(() => Take(events, got) && Has(got, "step_undone")
                    && Has(got, "state_changed") && Has(got, "misassembled"), 30, "events");
                SnapfitEvent wrong = got.Find(it => it.Kind == "misassembled");
                Check.Equal("pin", wrong.Part);
                Check.Equal("wrong_place", wrong.Data["kind"].AsString());
                Check.That(got.TrueForAll(it => it.AtUs > 0), "time stamps");
                Check.Equal("free", Live.Get(client.GetStepsAsync).Steps[0].FromState);
                Live.Ask("cut the connections");
                int before = got.Count;
                Live.Until(() => Take(events, got) && got.Count > before + 10, 30, "goes on");
                NoGaps(got);
            }
        }

        private static void Follow(PoseFeed feed, Transport transport)
        {
            PosePlayer player = new PosePlayer { PlayoutDelayUs = 60000 };
            Live.Until(() => Plays(feed, player), 30, transport + ": poses");
            long first = feed.Received;
            long fromUs = MonotonicClock.NowUs;
            long lastSeq = 0;
            List<double> startsM = new List<double>();
            // Half a minute at most, on a machine that has other things to do.
            while (feed.Received < first + Followed && MonotonicClock.NowUs - fromUs < 30000000)
            {
                PoseSnapshot latest;
                if (feed.TryTake(out latest))
                {
                    // The last one comes again, as stale, where the worker is held up.
                    Check.That(latest.Seq > lastSeq || (latest.Stale && latest.Seq == lastSeq),
                        transport + ": in order");
                    lastSeq = latest.Seq;
                    player.Add(latest);
                }
                long nowUs = feed.ServerNowUs;
                PoseSample jaw = player.Sample("jaw", nowUs);
                Check.That(jaw.Kind != SampleKind.None, transport + ": shown");
                if (jaw.Kind != SampleKind.Held)
                {
                    double wayM = VelocityMPerS * 1e-6 * (nowUs - player.PlayoutDelayUs
                        - 1700000000000000);
                    startsM.Add(jaw.Pose.Position.X - wayM);
                }
                Thread.Sleep(8);
            }
            double rate = (feed.Received - first) / (1e-6 * (MonotonicClock.NowUs - fromUs));
            List<double> errors = FromMedian(startsM);
            double median = errors[errors.Count / 2];
            Console.WriteLine(string.Format(System.Globalization.CultureInfo.InvariantCulture,
                "{0}: {1:F1} snapshots/s, shown within {2:F2} mm (median), {3:F2} mm (95 %)",
                transport, rate, 1e3 * median, 1e3 * errors[errors.Count * 95 / 100]));
            Check.That(feed.Received >= first + Followed, transport + ": rate " + rate);
            // 2 mm are 20 ms at 0.1 m/s, and the clock is as good as the network is.
            double room = 0.002 + VelocityMPerS * 1e-6 * feed.Clock.UncertaintyUs;
            Check.That(median < room, transport + ": median error " + median);
        }

        // Where it began, by each frame, is always the same.
        private static List<double> FromMedian(List<double> values)
        {
            values.Sort();
            double middle = values[values.Count / 2];
            List<double> away = values.ConvertAll(it => Math.Abs(it - middle));
            away.Sort();
            return away;
        }

        // Whether all have fresh poses of a worker after so many others.
        private static bool Play(PoseFeed[] feeds, PosePlayer[] players, int restarts)
        {
            bool isFresh = true;
            for (int place = 0; place < feeds.Length; place++)
            {
                isFresh &= Plays(feeds[place], players[place])
                    && feeds[place].Restarts == restarts;
            }
            return isFresh;
        }

        private static bool Plays(PoseFeed feed, PosePlayer player)
        {
            PoseSnapshot latest;
            if (feed.TryTake(out latest))
            {
                player.Add(latest);
            }
            return feed.State == FeedState.Live && feed.Clock.IsSynchronised
                && player.NewestUs > 0 && !player.IsStale(feed.ServerNowUs);
        }

        private static bool Take(EventFeed events, List<SnapfitEvent> got)
        {
            SnapfitEvent next;
            while (events.TryTake(out next))
            {
                got.Add(next);
            }
            return true;
        }

        private static bool Has(List<SnapfitEvent> got, string kind)
        {
            return got.Exists(it => it.Kind == kind);
        }

        // Ids end with a number that grows by one.
        private static void NoGaps(List<SnapfitEvent> got)
        {
            for (int place = 1; place < got.Count; place++)
            {
                Check.Equal(Number(got[place - 1]) + 1, Number(got[place]), "no gap, no repeat");
            }
        }

        private static long Number(SnapfitEvent it)
        {
            return long.Parse(it.Id.Substring(it.Id.LastIndexOf('-') + 1));
        }
    }
}
