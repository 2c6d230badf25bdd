using System;
using System.Globalization;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>Asks for what comes after the last snapshot; the server answers when it is there.
    /// </summary>
    internal sealed class LongPollTransport : IPoseTransport
    {
        // Stale answers come at once when their time is over: no more than one in so long.
        private const double LeastS = 0.005;

        private readonly HttpChannel channel;
        private readonly SnapfitOptions options;
        private readonly string path;

        public LongPollTransport(SnapfitOptions options, HttpChannel channel)
        {
            this.options = options;
            this.channel = channel;
            path = options.StationPath("/poses") + options.ViewQuery;
        }

        public async Task RunAsync(SnapshotInbox inbox, Action heard, CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            string wait = "";
            while (true)
            {
                // The ETag is for polling; here it would turn a stale answer into a 304.
                buffer.ETag = null;
                double extraS = wait.Length > 0 ? options.LongPollS : 0;
                int status = await channel.GetAsync(path + wait, buffer, extraS, token)
                    .ConfigureAwait(false);
                bool isNew = status == 200 && inbox.Put(buffer.Bytes, buffer.Count);
                heard();
                wait = "&after_seq=" + inbox.Seq.ToString(CultureInfo.InvariantCulture)
                    + "&boot_id=" + Uri.EscapeDataString(inbox.BootId ?? "") + "&timeout_s="
                    + options.LongPollS.ToString(CultureInfo.InvariantCulture);
                if (!isNew)
                {
                    await Task.Delay(TimeSpan.FromSeconds(LeastS), token).ConfigureAwait(false);
                }
            }
        }
    }
}
