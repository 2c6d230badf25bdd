namespace Snapfit
{
    /// <summary>How a feed does.</summary>
    public enum FeedState
    {
        /// <summary>Not started, or ended.</summary>
        Stopped,

        /// <summary>The server has not answered yet.</summary>
        Connecting,

        /// <summary>The server answers.</summary>
        Live,

        /// <summary>The server does not answer any more, or not yet; it is tried again.</summary>
        Reconnecting,

        /// <summary>The server says no, for example because a key is wrong or the anchor is not
        /// aligned yet; it is tried again.</summary>
        Refused,

        /// <summary>A mistake in this program ended it.</summary>
        Failed,
    }
}
