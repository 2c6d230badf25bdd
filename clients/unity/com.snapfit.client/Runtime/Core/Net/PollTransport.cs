using System;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>Asks at a fixed rate; 304 while nothing is new.</summary>
    internal sealed class PollTransport : IPoseTransport
    {
        private readonly HttpChannel channel;
        private readonly string path;
        private readonly TimeSpan period;

        public PollTransport(SnapfitOptions options, HttpChannel channel)
        {
            this.channel = channel;
            path = options.StationPath("/poses") + options.ViewQuery;
            period = TimeSpan.FromSeconds(1 / options.PollHz);
        }

        public async Task RunAsync(SnapshotInbox inbox, Action heard, CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            while (true)
            {
                Task pause = Task.Delay(period, token);
                int status = await channel.GetAsync(path, buffer, 0, token).ConfigureAwait(false);
                if (status == 200)
                {
                    inbox.Put(buffer.Bytes, buffer.Count);
                }
                heard();
                await pause.ConfigureAwait(false);
            }
        }
    }
}
