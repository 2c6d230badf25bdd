using System;
using System.Threading;
using UnityEngine;

namespace Snapfit.Unity
{
    /// <summary>Aligns the headset's world with the camera: the app tells where it sees the board
    /// that the camera sees too, and this passes it on to the server.</summary>
    /// <remarks>Call <see cref="Report"/> whenever the headset's own marker tracking has seen the
    /// board; MRTK, Quest and Magic Leap each do it in their way, which the package's
    /// documentation goes through.</remarks>
    [AddComponentMenu("Snapfit/Marker Alignment")]
    public sealed class MarkerAlignment : MonoBehaviour
    {
        [SerializeField] private SnapfitConnection connection;

        [Tooltip("How the marker tracker lays a marker's axes.")]
        [SerializeField] private MarkerAxes axes = MarkerAxes.ZIntoThePage;

        [Tooltip("From the tracked point to the board's middle, along x right and y up the page, "
            + "metres: for trackers that give a corner.")]
        [SerializeField] private Vector2 middle = Vector2.zero;

        [Tooltip("No more often than this, seconds.")]
        [Range(0.1f, 5f)]
        [SerializeField] private float periodS = 0.5f;

        [Tooltip("Begin to average anew when the server says that board and camera have drifted "
            + "apart.")]
        [SerializeField] private bool restartOnDrift = true;

        private readonly Pending<Anchor> pending = new Pending<Anchor>();
        private CancellationTokenSource ending;
        private RigidPose reported;
        private bool hasReport;
        private bool isRestarting;
        private double putAtS = double.NegativeInfinity;

        /// <summary>The server has answered: whether it is aligned, and how well.</summary>
        public event Action<Anchor> AnchorTaken;

        /// <summary>The connection whose anchor it is.</summary>
        public SnapfitConnection Connection
        {
            get { return connection; }
            set { connection = value; }
        }

        /// <summary>How the marker tracker lays a marker's axes.</summary>
        public MarkerAxes Axes
        {
            get { return axes; }
            set { axes = value; }
        }

        /// <summary>From the tracked point to the board's middle, metres: x right, y up the page.
        /// </summary>
        public Vector2 Middle
        {
            get { return middle; }
            set { middle = value; }
        }

        /// <summary>What both look at; null for the board that snapfit prints.</summary>
        public Board Board { get; set; }

        /// <summary>What the server answered the last time; null before.</summary>
        public Anchor Latest { get; private set; }

        /// <summary>Whether headset and camera have both seen the board.</summary>
        public bool IsAligned
        {
            get { return Latest != null && Latest.Aligned; }
        }

        /// <summary>What went wrong the last time, for people; null if nothing did.</summary>
        public string Problem { get; private set; }

        /// <summary>Where the marker tracker sees the marker, in Unity's world. Only what is seen
        /// now, not what is remembered.</summary>
        /// <param name="position">Unity's world, metres.</param>
        /// <param name="rotation">Unity's world.</param>
        public void Report(Vector3 position, Quaternion rotation)
        {
            reported = WorldFromMarker(position, rotation);
            hasReport = true;
        }

        /// <summary>The headset has found another place for its world: forget what was told.
        /// </summary>
        public void Restart()
        {
            isRestarting = true;
            hasReport = false;
        }

        /// <summary>origin_from_marker, of the board's middle and in snapfit's axes.</summary>
        /// <param name="position">As tracked, Unity's world, metres.</param>
        /// <param name="rotation">As tracked, Unity's world.</param>
        public RigidPose WorldFromMarker(Vector3 position, Quaternion rotation)
        {
            Transform origin = connection == null ? null : connection.Origin;
            if (origin != null)
            {
                position = origin.InverseTransformPoint(position);
                rotation = Quaternion.Inverse(origin.rotation) * rotation;
            }
            RigidPose tracked = UnitySpace.ToPose(position, rotation);
            RigidPose turned = tracked * new RigidPose(
                Vec3.Zero, MarkerAxesMap.TrackedFromMarker(axes));
            return turned * new RigidPose(new Vec3(middle.x, middle.y, 0), Quat.Identity);
        }

        private void OnEnable()
        {
            ending = new CancellationTokenSource();
        }

        private void OnDisable()
        {
            ending.Cancel();
        }

        private void Update()
        {
            Anchor anchor;
            Exception error;
            if (pending.TryTake(out anchor, out error))
            {
                Take(anchor, error);
            }
            double nowS = Time.unscaledTimeAsDouble;
            bool isTime = nowS - putAtS >= periodS;
            if (!hasReport || !isTime || pending.IsBusy || connection == null
                || connection.Client == null)
            {
                return;
            }
            if (string.IsNullOrEmpty(connection.AnchorId))
            {
                Problem = "The connection has no anchor: give it a name, one for each headset.";
                return;
            }
            putAtS = nowS;
            hasReport = false;
            AnchorWish wish = new AnchorWish(reported, Convention.Unity)
            {
                Board = Board,
                Restart = isRestarting,
            };
            pending.Begin(
                connection.Client.PutAnchorAsync(connection.AnchorId, wish, ending.Token));
        }

        private void Take(Anchor anchor, Exception error)
        {
            Problem = error == null ? null : error.Message;
            if (anchor == null)
            {
                return;
            }
            Latest = anchor;
            isRestarting = restartOnDrift && anchor.Drifting;
            AnchorTaken?.Invoke(anchor);
        }
    }
}
