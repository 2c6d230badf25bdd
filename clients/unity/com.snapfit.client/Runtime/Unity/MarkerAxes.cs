namespace Snapfit.Unity
{
    /// <summary>How a marker tracker lays the axes of a marker, as it is read, when its poses
    /// arrive in Unity's left-handed world.</summary>
    public enum MarkerAxes
    {
        /// <summary>x right, y up the page, z into it: snapfit's own.</summary>
        ZIntoThePage,

        /// <summary>x left, y up the page, z out of it, towards the reader.</summary>
        ZOutOfThePage,

        /// <summary>x right, z up the page, y out of it: like a plane of Unity, a Vuforia image
        /// target, an image of AR Foundation.</summary>
        YOutOfThePage,

        /// <summary>x right, y down the page, z out of it, towards the reader.</summary>
        YDownThePage,
    }

    /// <summary>From a tracker's axes to snapfit's.</summary>
    public static class MarkerAxesMap
    {
        private const double Half = 0.70710678118654757;

        /// <summary>tracked_from_marker: how snapfit's marker frame (x right, y up the page, z
        /// into it) lies in the tracker's.</summary>
        public static Quat TrackedFromMarker(MarkerAxes axes)
        {
            switch (axes)
            {
                case MarkerAxes.ZOutOfThePage:
                    return new Quat(0, 1, 0, 0);
                case MarkerAxes.YOutOfThePage:
                    // y to z, z to -y.
                    return new Quat(Half, 0, 0, Half);
                case MarkerAxes.YDownThePage:
                    return new Quat(1, 0, 0, 0);
                default:
                    return Quat.Identity;
            }
        }
    }
}
