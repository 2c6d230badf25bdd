using System;
using System.Collections.Concurrent;
using System.IO;
using System.Net.Http;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>What happens at the station, in order and without gaps: after an interruption it
    /// asks for what it missed.</summary>
    public sealed class EventFeed : IDisposable
    {
        /// <summary>No more events wait for the main thread; the oldest are let go of.</summary>
        public const int MaxWaiting = 1000;

        // The server says something every 10 s.
        private const double SilenceS = 25;

        private readonly SnapfitOptions options;
        private readonly SnapfitClient client;
        private readonly RetryLoop loop;
        private readonly SseParser parser = new SseParser();
        private readonly ConcurrentQueue<SnapfitEvent> waiting =
            new ConcurrentQueue<SnapfitEvent>();

        private readonly CancellationTokenSource ending = new CancellationTokenSource();
        private Task running;

        /// <summary>Not started yet.</summary>
        /// <param name="options">Where from.</param>
        /// <param name="client">What it asks through; stays its owner's.</param>
        public EventFeed(SnapfitOptions options, SnapfitClient client)
        {
            this.options = options;
            this.client = client;
            loop = new RetryLoop(options, new Random());
        }

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

        /// <summary>Begin, in threads of the pool.</summary>
        /// <exception cref="InvalidOperationException">It has begun already.</exception>
        public void Start()
        {
            if (running != null)
            {
                throw new InvalidOperationException("The feed has been started already.");
            }
            CancellationToken token = ending.Token;
            running = Task.Run(() => loop.RunAsync(AttemptAsync, parser.Reset, token));
        }

        /// <summary>The next event, for the main thread; false where there is none.</summary>
        public bool TryTake(out SnapfitEvent next)
        {
            return waiting.TryDequeue(out next);
        }

        /// <summary>Ends it.</summary>
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
            string path = options.StationPath("/events");
            using (HttpResponseMessage response = await client.Channel.OpenAsync(
                path, parser.LastId, token).ConfigureAwait(false))
            using (token.Register(response.Dispose))
            using (Watchdog watchdog = new Watchdog(SilenceS, response.Dispose))
            {
                loop.Heard();
                try
                {
                    Stream stream = await response.Content.ReadAsStreamAsync()
                        .ConfigureAwait(false);
                    await ReadAsync(stream, watchdog, token).ConfigureAwait(false);
                }
                catch (Exception error) when (HttpChannel.IsTrouble(error))
                {
                    token.ThrowIfCancellationRequested();
                    throw new UnreachableException("The events broke off: " + error.Message, error);
                }
            }
            throw new UnreachableException("The server ended the events.");
        }

        private async Task ReadAsync(Stream stream, Watchdog watchdog, CancellationToken token)
        {
            byte[] bytes = new byte[4096];
            int read;
            while ((read = await stream.ReadAsync(bytes, 0, bytes.Length, token)
                .ConfigureAwait(false)) > 0)
            {
                watchdog.Heard();
                for (int place = 0; place < read; place++)
                {
                    if (parser.Take(bytes[place]))
                    {
                        Put(new SnapfitEvent(
                            parser.LastId, parser.Kind, JsonValue.Parse(parser.Data)));
                    }
                }
            }
        }

        private void Put(SnapfitEvent next)
        {
            waiting.Enqueue(next);
            SnapfitEvent oldest;
            while (waiting.Count > MaxWaiting && waiting.TryDequeue(out oldest))
            {
                // Nobody takes them.
            }
        }
    }
}
