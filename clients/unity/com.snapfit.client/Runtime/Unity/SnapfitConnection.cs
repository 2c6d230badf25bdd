using System;
using UnityEngine;

namespace Snapfit.Unity
{
    /// <summary>The connection to a snapfit server; one for a scene. Everything else here asks it.
    /// It comes back by itself after every interruption, and stops while the app is paused.
    /// </summary>
    [AddComponentMenu("Snapfit/Snapfit Connection")]
    [DefaultExecutionOrder(-100)]
    [DisallowMultipleComponent]
    public sealed class SnapfitConnection : MonoBehaviour
    {
        [Header("Server")]
        [Tooltip("Scheme, host and port, such as http://192.168.1.20:8000.")]
        [SerializeField] private string address = "http://127.0.0.1:8000";

        [Tooltip("The workbench; empty for a server's only one.")]
        [SerializeField] private string station = "";

        [Tooltip("The API key; empty where the server needs none. Do not ship keys in a build: "
            + "set ApiKey from the app's settings.")]
        [SerializeField] private string apiKey = "";

        [Tooltip("How snapshots come.")]
        [SerializeField] private Transport transport = Transport.Auto;

        [Header("World")]
        [Tooltip("This headset's name for the server's alignment; empty to get poses in the "
            + "camera's frame.")]
        [SerializeField] private string anchorId = "";

        [Tooltip("The frame that the anchor was given in; none for Unity's world.")]
        [SerializeField] private Transform origin;

        [Header("Playback")]
        [Tooltip("Poses are shown so late, milliseconds: 100 is smooth, 0 is prompt and "
            + "predicted.")]
        [Range(0, 500)]
        [SerializeField] private int playoutDelayMs = 100;

        [Tooltip("Without news for so long, all is stale, seconds.")]
        [Range(0.1f, 5f)]
        [SerializeField] private float staleAfterS = 0.5f;

        private readonly PosePlayer player = new PosePlayer();
        private PoseFeed feed;
        private EventFeed events;
        private PoseSnapshot latest;
        private bool isFailureTold;

        /// <summary>A new snapshot is here; it is filled anew later, so copy what is to be kept.
        /// </summary>
        public event Action<PoseSnapshot> SnapshotTaken;

        /// <summary>Something happened at the station.</summary>
        public event Action<SnapfitEvent> EventTaken;

        /// <summary>The server's address; a change counts from the next time it is enabled.
        /// </summary>
        public string Address
        {
            get { return address; }
            set { address = value; }
        }

        /// <summary>The workbench; a change counts from the next time it is enabled.</summary>
        public string Station
        {
            get { return station; }
            set { station = value; }
        }

        /// <summary>The API key; a change counts from the next time it is enabled.</summary>
        public string ApiKey
        {
            get { return apiKey; }
            set { apiKey = value; }
        }

        /// <summary>How snapshots come; a change counts from the next time it is enabled.
        /// </summary>
        public Transport Transport
        {
            get { return transport; }
            set { transport = value; }
        }

        /// <summary>This headset's name for the alignment; a change counts from the next time it
        /// is enabled.</summary>
        public string AnchorId
        {
            get { return anchorId; }
            set { anchorId = value; }
        }

        /// <summary>The frame that the anchor was given in; null for Unity's world.</summary>
        public Transform Origin
        {
            get { return origin; }
            set { origin = value; }
        }

        /// <summary>How late poses are shown, milliseconds.</summary>
        public int PlayoutDelayMs
        {
            get { return playoutDelayMs; }
            set { playoutDelayMs = value; }
        }

        /// <summary>Requests of your own; null while this is disabled.</summary>
        public SnapfitClient Client { get; private set; }

        /// <summary>The latest snapshot; null before the first.</summary>
        public PoseSnapshot Latest
        {
            get { return latest; }
        }

        /// <summary>How the connection does.</summary>
        public FeedState State
        {
            get { return feed == null ? FeedState.Stopped : feed.State; }
        }

        /// <summary>What went wrong the last time, for people; null if nothing did.</summary>
        public string Problem
        {
            get
            {
                Exception error = feed == null || State == FeedState.Live ? null : feed.LastError;
                return error == null ? null : error.Message;
            }
        }

        /// <summary>The server's time now, microseconds.</summary>
        public long ServerNowUs
        {
            get { return feed == null ? 0 : feed.ServerNowUs; }
        }

        /// <summary>Whether nothing fresh comes.</summary>
        public bool IsStale
        {
            get { return !IsPlaying || player.IsStale(ServerNowUs); }
        }

        private bool IsPlaying
        {
            get { return feed != null && feed.Clock.IsSynchronised; }
        }

        /// <summary>A part at the time that is shown now, in the frame of
        /// <see cref="Origin"/>.</summary>
        public PoseSample Sample(string part)
        {
            return IsPlaying
                ? player.Sample(part, ServerNowUs) : new PoseSample { IsStale = true };
        }

        /// <summary>Begin with other settings.</summary>
        public void Reconnect()
        {
            Close();
            Open();
        }

        private void OnEnable()
        {
            Open();
        }

        private void OnDisable()
        {
            Close();
        }

        private void OnApplicationPause(bool isPaused)
        {
            if (isPaused)
            {
                Close();
            }
            else if (isActiveAndEnabled && feed == null)
            {
                Open();
            }
        }

        private void Update()
        {
            if (feed == null)
            {
                return;
            }
            TellFailure();
            player.PlayoutDelayUs = 1000L * playoutDelayMs;
            player.StaleAfterUs = (long)(1e6 * staleAfterS);
            PoseSnapshot snapshot;
            if (feed.TryTake(out snapshot))
            {
                latest = snapshot;
                player.Add(snapshot);
                SnapshotTaken?.Invoke(snapshot);
            }
            SnapfitEvent happened;
            while (events != null && events.TryTake(out happened))
            {
                EventTaken?.Invoke(happened);
            }
        }

        // A mistake in the program, never the network's: it must not pass unseen.
        private void TellFailure()
        {
            if (feed.State == FeedState.Failed && !isFailureTold)
            {
                isFailureTold = true;
                Debug.LogException(feed.LastError, this);
            }
        }

        private void Open()
        {
            SnapfitOptions options;
            try
            {
                options = new SnapfitOptions(address)
                {
                    Station = station,
                    ApiKey = apiKey,
                    Transport = transport,
                    Convention = Convention.Unity,
                    Frame = string.IsNullOrEmpty(anchorId) ? "camera" : "anchor:" + anchorId,
                };
            }
            catch (ArgumentException error)
            {
                Debug.LogError("Snapfit Connection: " + error.Message, this);
                return;
            }
            Client = new SnapfitClient(options);
            feed = new PoseFeed(options, Client);
            events = new EventFeed(options, Client);
            isFailureTold = false;
            feed.Start();
            events.Start();
        }

        private void Close()
        {
            if (feed == null)
            {
                return;
            }
            feed.Dispose();
            events.Dispose();
            Client.Dispose();
            feed = null;
            events = null;
            Client = null;
        }
    }
}
