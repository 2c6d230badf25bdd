using Snapfit.Unity;
using UnityEngine;

namespace Snapfit.Samples
{
    /// <summary>Tells the wearer how the connection does; bind the text in the inspector.
    /// </summary>
    public sealed class ConnectionLabel : MonoBehaviour
    {
        [SerializeField] private SnapfitConnection connection;
        [SerializeField] private MarkerAlignment alignment;
        [SerializeField] private TextEvent text = new TextEvent();

        private string shown;

        private void Update()
        {
            string next = Line();
            if (next != shown)
            {
                shown = next;
                text.Invoke(next);
            }
        }

        private string Line()
        {
            if (connection.Problem != null)
            {
                return connection.Problem;
            }
            if (connection.State != FeedState.Live)
            {
                return "Connecting to " + connection.Address;
            }
            if (alignment != null && alignment.Latest != null && alignment.Latest.Drifting)
            {
                return "Look at the board again: headset and camera have drifted apart.";
            }
            return connection.IsStale ? "No fresh poses" : "";
        }
    }
}
