using System;
using System.Net.WebSockets;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>Every snapshot as it comes, over a WebSocket.</summary>
    internal sealed class WebSocketTransport : IPoseTransport
    {
        // The server is silent while its worker is down; then we look whether it is still there.
        private const double SilenceS = 4;

        private readonly SnapfitOptions options;
        private readonly HttpChannel channel;
        private readonly string path;

        public WebSocketTransport(SnapfitOptions options, HttpChannel channel)
        {
            this.options = options;
            this.channel = channel;
            path = options.ViewQuery;
        }

        /// <summary>As the transports do; besides:</summary>
        /// <exception cref="NotSupportedException">There are no WebSockets here: the platform has
        /// none, or something between does not let them through, while HTTP works.</exception>
        public async Task RunAsync(SnapshotInbox inbox, Action heard, CancellationToken token)
        {
            using (ClientWebSocket socket = new ClientWebSocket())
            {
                await ConnectAsync(socket, token).ConfigureAwait(false);
                // Cancelling a receive does not end it everywhere; aborting the socket does.
                using (token.Register(socket.Abort))
                using (Watchdog watchdog = new Watchdog(
                    SilenceS, () => ProbeAsync(socket, inbox, token)))
                {
                    ResponseBuffer buffer = new ResponseBuffer();
                    while (true)
                    {
                        await ReceiveAsync(socket, buffer, token).ConfigureAwait(false);
                        watchdog.Heard();
                        inbox.Put(buffer.Bytes, buffer.Count);
                        heard();
                    }
                }
            }
        }

        private async Task ConnectAsync(ClientWebSocket socket, CancellationToken token)
        {
            UriBuilder address = new UriBuilder(options.Address)
            {
                Scheme = options.Address.Scheme == "https" ? "wss" : "ws",
                Path = options.StationPath("/stream"),
                Query = path.Substring(1),
            };
            string authorization = HttpChannel.Authorization(options);
            if (authorization != null)
            {
                socket.Options.SetRequestHeader("Authorization", authorization);
            }
            using (Deadline deadline = new Deadline(options.TimeoutS, token))
            {
                try
                {
                    await socket.ConnectAsync(address.Uri, deadline.Token).ConfigureAwait(false);
                    return;
                }
                catch (Exception error) when (HttpChannel.IsTrouble(error)
                    || error is PlatformNotSupportedException)
                {
                    token.ThrowIfCancellationRequested();
                }
            }
            // A refused handshake does not tell why; the same question over HTTP does, by an
            // exception. Where that is answered, WebSockets do not work here.
            string poses = options.StationPath("/poses") + options.ViewQuery;
            await channel.GetAsync(poses, new ResponseBuffer(), 0, token).ConfigureAwait(false);
            throw new NotSupportedException(
                "The server answers over HTTP, but a WebSocket cannot be opened.");
        }

        private static async Task ReceiveAsync(
            ClientWebSocket socket, ResponseBuffer buffer, CancellationToken token)
        {
            buffer.Clear();
            try
            {
                WebSocketReceiveResult result;
                do
                {
                    result = await socket.ReceiveAsync(buffer.Room(), CancellationToken.None)
                        .ConfigureAwait(false);
                    buffer.Taken(result.Count);
                }
                while (!result.EndOfMessage && result.MessageType != WebSocketMessageType.Close);
                if (result.MessageType == WebSocketMessageType.Close)
                {
                    throw new UnreachableException(
                        "The server closed the stream (" + result.CloseStatus + ").");
                }
            }
            catch (Exception error) when (HttpChannel.IsTrouble(error)
                || error is InvalidOperationException)
            {
                token.ThrowIfCancellationRequested();
                throw new UnreachableException("The stream broke off: " + error.Message, error);
            }
        }

        /// <summary>A connection can be dead without anybody having said so. Where the server has
        /// news that did not come, or does not answer, it is.</summary>
        private async Task ProbeAsync(
            ClientWebSocket socket, SnapshotInbox inbox, CancellationToken token)
        {
            try
            {
                ResponseBuffer buffer = new ResponseBuffer();
                string poses = options.StationPath("/poses") + options.ViewQuery;
                long before = inbox.Received;
                await channel.GetAsync(poses, buffer, 0, token).ConfigureAwait(false);
                PoseSnapshot now = new PoseSnapshot();
                new SnapshotReader().Read(buffer.Bytes, buffer.Count, now);
                bool isKnown = now.BootId == inbox.BootId && now.Seq == inbox.Seq;
                if (isKnown || inbox.Received > before)
                {
                    return;
                }
            }
            catch (SnapfitException)
            {
                // What is wrong shows when it is connected anew.
            }
            catch (OperationCanceledException)
            {
                return;
            }
            socket.Abort();
        }
    }
}
