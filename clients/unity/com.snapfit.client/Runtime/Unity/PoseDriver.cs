using System;
using UnityEngine;

namespace Snapfit.Unity
{
    /// <summary>Puts this object where a part is, and hides what it shows while the part has no
    /// pose.</summary>
    [AddComponentMenu("Snapfit/Pose Driver")]
    public sealed class PoseDriver : MonoBehaviour
    {
        [SerializeField] private SnapfitConnection connection;

        [Tooltip("The part's name in its asset.")]
        [SerializeField] private string part = "";

        [Tooltip("What is shown and hidden: a child of this object, such as the part's mesh.")]
        [SerializeField] private GameObject visual;

        [Tooltip("Hide it while nothing fresh comes; else it stays where it was.")]
        [SerializeField] private bool hideWhenStale = true;

        [Tooltip("Hide it while its pose is less probable than this.")]
        [Range(0f, 1f)]
        [SerializeField] private float leastConfidence;

        /// <summary>It is shown now, or hidden.</summary>
        public event Action<bool> VisibilityChanged;

        /// <summary>The connection that it asks.</summary>
        public SnapfitConnection Connection
        {
            get { return connection; }
            set { connection = value; }
        }

        /// <summary>The part's name in its asset.</summary>
        public string Part
        {
            get { return part; }
            set { part = value; }
        }

        /// <summary>What is shown and hidden: a child of this object.</summary>
        public GameObject Visual
        {
            get { return visual; }
            set { visual = value; }
        }

        /// <summary>Whether it is hidden while nothing fresh comes.</summary>
        public bool HideWhenStale
        {
            get { return hideWhenStale; }
            set { hideWhenStale = value; }
        }

        /// <summary>Whether it is shown.</summary>
        public bool IsShown { get; private set; }

        /// <summary>The part as it was shown the last time.</summary>
        public PoseSample Sample { get; private set; }

        /// <summary>Places and shows, or hides, by a sample; what happens every frame.</summary>
        /// <param name="sample">In the frame of the origin.</param>
        /// <param name="origin">Null for Unity's world.</param>
        public void Apply(PoseSample sample, Transform origin)
        {
            Sample = sample;
            bool isShown = sample.Kind != SampleKind.None && !(sample.IsStale && hideWhenStale)
                && sample.Confidence >= leastConfidence;
            if (sample.Kind != SampleKind.None)
            {
                UnitySpace.Place(transform, sample.Pose, origin);
            }
            Show(isShown);
        }

        private void OnEnable()
        {
            if (visual == gameObject)
            {
                // Hidden, it could not show itself again.
                Debug.LogError("Pose Driver: what is shown must be a child of the object.", this);
                visual = null;
            }
            Show(false, true);
        }

        // After the connection's Update, before anything is drawn.
        private void LateUpdate()
        {
            if (connection != null)
            {
                Apply(connection.Sample(part), connection.Origin);
            }
        }

        private void Show(bool isShown, bool always = false)
        {
            if (isShown == IsShown && !always)
            {
                return;
            }
            IsShown = isShown;
            if (visual != null)
            {
                visual.SetActive(isShown);
            }
            VisibilityChanged?.Invoke(isShown);
        }
    }
}
