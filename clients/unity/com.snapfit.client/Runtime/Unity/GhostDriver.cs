using System;
using UnityEngine;

namespace Snapfit.Unity
{
    /// <summary>Shows where the next part belongs: its ghost, on the part that will carry it.
    /// </summary>
    [AddComponentMenu("Snapfit/Ghost Driver")]
    public sealed class GhostDriver : MonoBehaviour
    {
        /// <summary>What stands for a part.</summary>
        [Serializable]
        public struct PartVisual
        {
            /// <summary>The part's name in its asset.</summary>
            public string Part;

            /// <summary>A child of the driver: the part's mesh, see-through.</summary>
            public GameObject Visual;
        }

        [SerializeField] private StepGuide guide;

        [Tooltip("A see-through mesh for each part; children of this object.")]
        [SerializeField] private PartVisual[] visuals = new PartVisual[0];

        /// <summary>Whose step's ghost is shown.</summary>
        public StepGuide Guide
        {
            get { return guide; }
            set { guide = value; }
        }

        /// <summary>What stands for each part.</summary>
        public PartVisual[] Visuals
        {
            get { return visuals; }
            set { visuals = value; }
        }

        /// <summary>The part whose ghost is shown, or null.</summary>
        public string Shown { get; private set; }

        /// <summary>Places and shows a ghost, or hides all; what happens every frame.</summary>
        /// <param name="ghost">Null where the step has none.</param>
        /// <param name="parent">The part that will carry it.</param>
        /// <param name="origin">Null for Unity's world.</param>
        public void Apply(Ghost ghost, PoseSample parent, Transform origin)
        {
            bool isShown = ghost != null && parent.Kind != SampleKind.None && !parent.IsStale;
            if (isShown)
            {
                UnitySpace.Place(transform, parent.Pose * ghost.ParentFromPart, origin);
            }
            Show(isShown ? ghost.Part : null);
        }

        private void OnEnable()
        {
            Show(null);
        }

        private void LateUpdate()
        {
            SnapfitConnection connection = guide == null ? null : guide.Connection;
            if (connection == null)
            {
                return;
            }
            Ghost ghost = guide.Current == null ? null : guide.Current.Ghost;
            Apply(ghost, connection.Sample(ghost == null ? null : ghost.Parent), connection.Origin);
        }

        private void Show(string part)
        {
            Shown = part;
            foreach (PartVisual each in visuals)
            {
                bool isIt = part != null && each.Part == part;
                if (each.Visual != null && each.Visual.activeSelf != isIt)
                {
                    each.Visual.SetActive(isIt);
                }
            }
        }
    }
}
