using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Samples
{
    /// <summary>Reports where the marker tracker has put this object.</summary>
    public sealed class MarkerReporter : MonoBehaviour
    {
        [SerializeField] private MarkerAlignment alignment;

        [Tooltip("Report every frame while this is active; else only when Seen is called.")]
        [SerializeField] private bool everyFrame = true;

        /// <summary>The tracker has seen the marker just now.</summary>
        public void Seen()
        {
            alignment.Report(transform.position, transform.rotation);
        }

        private void Update()
        {
            if (everyFrame)
            {
                Seen();
            }
        }
    }
}
