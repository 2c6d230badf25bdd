using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>Plays snapshots on the main thread: for the moment that is shown it gives each
    /// part's pose, between snapshots or a little after the latest.</summary>
    /// <remarks>With a playout delay of about two frames of the camera and the network's jitter
    /// (100 ms) poses are between snapshots and motion is smooth, and late by as much; with a
    /// delay of zero they are predicted by velocities, and prompt.</remarks>
    public sealed class PosePlayer
    {
        private readonly Dictionary<string, PoseTrack> tracks =
            new Dictionary<string, PoseTrack>();

        private string bootId;
        private string frame;
        private Convention convention;
        private bool isStale = true;
        private long newestUs;

        /// <summary>How far behind the server's time poses are shown, microseconds.</summary>
        public long PlayoutDelayUs { get; set; } = 100000;

        /// <summary>Without anything newer for so long, all is stale, microseconds: the network
        /// can be gone, and then nobody says so.</summary>
        public long StaleAfterUs { get; set; } = 500000;

        /// <summary>Exposure of the newest snapshot, server's time, microseconds; 0 before it.
        /// </summary>
        public long NewestUs
        {
            get { return newestUs; }
        }

        /// <summary>Takes a snapshot in. Of another run of the worker, another frame or another
        /// convention, what was before does not count any more.</summary>
        public void Add(PoseSnapshot snapshot)
        {
            bool isAnother = snapshot.BootId != bootId || snapshot.Frame != frame
                || snapshot.Convention != convention;
            if (isAnother)
            {
                bootId = snapshot.BootId;
                frame = snapshot.Frame;
                convention = snapshot.Convention;
                foreach (PoseTrack track in tracks.Values)
                {
                    track.Clear();
                }
            }
            isStale = snapshot.Stale;
            newestUs = snapshot.CapturedAtUs;
            for (int place = 0; place < snapshot.PartCount; place++)
            {
                PartPose part = snapshot[place];
                PoseTrack track;
                if (!tracks.TryGetValue(part.Part, out track))
                {
                    track = new PoseTrack();
                    tracks.Add(part.Part, track);
                }
                track.Add(snapshot.CapturedAtUs, part);
            }
        }

        /// <summary>Whether nothing fresh came.</summary>
        /// <param name="serverNowUs">The server's time now.</param>
        public bool IsStale(long serverNowUs)
        {
            return isStale || serverNowUs - newestUs > StaleAfterUs;
        }

        /// <summary>A part at the time that is shown; none for a part that never came.</summary>
        /// <param name="part">Its name.</param>
        /// <param name="serverNowUs">The server's time now.</param>
        public PoseSample Sample(string part, long serverNowUs)
        {
            PoseTrack track;
            if (part == null || !tracks.TryGetValue(part, out track))
            {
                return new PoseSample { IsStale = IsStale(serverNowUs) };
            }
            PoseSample sample = track.At(serverNowUs - PlayoutDelayUs);
            sample.IsStale = IsStale(serverNowUs);
            return sample;
        }
    }
}
