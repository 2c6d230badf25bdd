using System;
using System.Collections.Generic;

namespace Snapfit
{
    /// <summary>The poses of all parts in one frame. The feed fills the same few objects again and
    /// again, so that nothing is allocated while they come: copy what is to be kept.</summary>
    public sealed class PoseSnapshot
    {
        private readonly List<PartPose> parts = new List<PartPose>();
        private int count;

        /// <summary>The workbench.</summary>
        public string Station { get; internal set; }

        /// <summary>The asset under assembly; null where loose parts are tracked.</summary>
        public string Asset { get; internal set; }

        /// <summary>Names one run of the station's worker; with another one, seq begins again.
        /// </summary>
        public string BootId { get; internal set; }

        /// <summary>Grows by one with each snapshot of a boot_id.</summary>
        public long Seq { get; internal set; }

        /// <summary>The worker is down or the snapshot too old: do not rely on it.</summary>
        public bool Stale { get; internal set; }

        /// <summary>Exposure of the frame, microseconds of the server's time.</summary>
        public long CapturedAtUs { get; internal set; }

        /// <summary>When the tracker was done with it, microseconds of the server's time.</summary>
        public long PublishedAtUs { get; internal set; }

        /// <summary>The frame that poses are given in: camera, or anchor:ID.</summary>
        public string Frame { get; internal set; }

        /// <summary>The axes that everything is given in.</summary>
        public Convention Convention { get; internal set; }

        /// <summary>From the exposure to the answer, microseconds, by the server's clock.
        /// </summary>
        public long AgeUs { get; internal set; }

        /// <summary>Whether anything follows the assembly.</summary>
        public bool HasAssembly { get; internal set; }

        /// <summary>The assembly; of use only where something follows it.</summary>
        public AssemblySummary Assembly { get; } = new AssemblySummary();

        /// <summary>How many parts there are.</summary>
        public int PartCount
        {
            get { return count; }
        }

        /// <summary>A part, in the order of the server.</summary>
        public PartPose this[int place]
        {
            get
            {
                if (place < 0 || place >= count)
                {
                    throw new ArgumentOutOfRangeException("place");
                }
                return parts[place];
            }
        }

        /// <summary>The part of a name; null if there is none.</summary>
        public PartPose Find(string part)
        {
            for (int place = 0; place < count; place++)
            {
                if (parts[place].Part == part)
                {
                    return parts[place];
                }
            }
            return null;
        }

        internal void Clear()
        {
            count = 0;
            Station = Asset = BootId = Frame = null;
            Seq = CapturedAtUs = PublishedAtUs = AgeUs = 0;
            Stale = true;
            HasAssembly = false;
        }

        internal PartPose Add()
        {
            if (count == parts.Count)
            {
                parts.Add(new PartPose());
            }
            PartPose part = parts[count++];
            part.Clear();
            return part;
        }
    }
}
