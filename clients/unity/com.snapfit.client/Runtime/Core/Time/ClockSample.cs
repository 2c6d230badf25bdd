namespace Snapfit
{
    /// <summary>The four stamps of one request for the time, microseconds.</summary>
    public readonly struct ClockSample
    {
        /// <summary>When the client sent it, by its own clock (c1).</summary>
        public readonly long ClientSentUs;

        /// <summary>When the server took it up (t1).</summary>
        public readonly long ServerReceivedUs;

        /// <summary>When the server sent its answer (t2).</summary>
        public readonly long ServerSentUs;

        /// <summary>When the client had it, by its own clock (c2).</summary>
        public readonly long ClientReceivedUs;

        /// <summary>In the order in which they are taken.</summary>
        public ClockSample(
            long clientSentUs, long serverReceivedUs, long serverSentUs, long clientReceivedUs)
        {
            ClientSentUs = clientSentUs;
            ServerReceivedUs = serverReceivedUs;
            ServerSentUs = serverSentUs;
            ClientReceivedUs = clientReceivedUs;
        }

        /// <summary>Server time minus client time, microseconds; wrong by half the round trip at
        /// most.</summary>
        public double OffsetUs
        {
            get
            {
                return 0.5 * ((ServerReceivedUs - ClientSentUs)
                    + (ServerSentUs - ClientReceivedUs));
            }
        }

        /// <summary>Time on the network, both ways, microseconds.</summary>
        public long RoundTripUs
        {
            get { return ClientReceivedUs - ClientSentUs - (ServerSentUs - ServerReceivedUs); }
        }
    }
}
