using System;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>A way for snapshots to come.</summary>
    internal interface IPoseTransport
    {
        /// <summary>Puts snapshots into the inbox until it fails or is ended.</summary>
        /// <param name="inbox">Where they go.</param>
        /// <param name="heard">Called whenever the server answered, new or not.</param>
        /// <param name="token">Ends it.</param>
        Task RunAsync(SnapshotInbox inbox, Action heard, CancellationToken token);
    }
}
