using System;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>Poses that keep coming: connects, comes back after every interruption, keeps the
    /// clock, and has the latest snapshot ready for the main thread.</summary>
    public sealed class PoseFeed : IDisposable
    {
        private const int ClosedDoors = 2;

        private readonly SnapfitOptions options;
        private readonly SnapfitClient client;
        private readonly RetryLoop loop;
        private readonly SnapshotInbox inbox = new SnapshotInbox();
        private readonly ClockKeeper keeper;
        private readonly CancellationTokenSource ending = new CancellationTokenSource();
        private Task running;
        private Transport transport;
        private int closedDoors;

        /// <summary>Not started yet.</summary>
        /// <param name="options">Where from, and how.</param>
        /// <param name="client">What it asks through; stays its owner's.</param>
        public PoseFeed(SnapfitOptions options, SnapfitClient client)
        {
            this.options = options;
            this.client = client;
            loop = new RetryLoop(options, new Random());
            Clock = new ClockSync();
            keeper = new ClockKeeper(client, Clock);
            transport = options.Transport == Transport.Auto
                ? Transport.WebSocket : options.Transport;
        }

        /// <summary>The server's time line.</summary>
        public ClockSync Clock { get; private set; }

        /// <summary>How it does.</summary>
        public FeedState State
        {
            get { return loop.State; }
        }

        /// <summary>What went wrong the last time; null if nothing did.</summary>
        public Exception LastError
        {
            get { return loop.LastError; }
        }

        /// <summary>How snapshots come now: never <see cref="Transport.Auto"/>.</summary>
        public Transport TransportInUse
        {
            get { return transport; }
        }

        /// <summary>How many new snapshots came.</summary>
        public long Received
        {
            get { return inbox.Received; }
        }

        /// <summary>How often the server's worker was another one.</summary>
        public int Restarts
        {
            get { return inbox.Restarts; }
        }

        /// <summary>The server's time now, microseconds.</summary>
        public long ServerNowUs
        {
            get { return Clock.ServerUs(MonotonicClock.NowUs); }
        }

        /// <summary>Begin, in threads of the pool.</summary>
        /// <exception cref="InvalidOperationException">It has begun already.</exception>
        public void Start()
        {
            if (running != null)
            {
                throw new InvalidOperationException("The feed has been started already.");
            }
            CancellationToken token = ending.Token;
            running = Task.WhenAll(
                Task.Run(() => keeper.RunAsync(token)),
                Task.Run(() => loop.RunAsync(AttemptAsync, keeper.Restart, token)));
        }

        /// <summary>The latest snapshot, for the main thread; false where it has that already.
        /// What is taken stays untouched until the next one is.</summary>
        public bool TryTake(out PoseSnapshot latest)
        {
            return inbox.TryTake(out latest);
        }

        /// <summary>Ends it; what it waits for is given up.</summary>
        public void Dispose()
        {
            ending.Cancel();
        }

        /// <summary>Until it has ended.</summary>
        public Task Ended
        {
            get { return running ?? Task.CompletedTask; }
        }

        private async Task AttemptAsync(CancellationToken token)
        {
            try
            {
                await Make().RunAsync(inbox, Heard, token).ConfigureAwait(false);
            }
            catch (NotSupportedException error)
            {
                // Once can be chance: a server that came up between two requests.
                if (options.Transport != Transport.Auto || ++closedDoors < ClosedDoors)
                {
                    throw new UnreachableException(error.Message, error);
                }
                transport = Transport.LongPoll;
            }
        }

        private void Heard()
        {
            closedDoors = 0;
            loop.Heard();
        }

        private IPoseTransport Make()
        {
            switch (transport)
            {
                case Transport.WebSocket:
                    return new WebSocketTransport(options, client.Channel);
                case Transport.LongPoll:
                    return new LongPollTransport(options, client.Channel);
                default:
                    return new PollTransport(options, client.Channel);
            }
        }
    }
}
