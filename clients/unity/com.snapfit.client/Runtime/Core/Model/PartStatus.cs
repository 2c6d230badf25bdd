namespace Snapfit
{
    /// <summary>Where a part's pose comes from.</summary>
    public enum PartStatus
    {
        /// <summary>Not found yet; no pose.</summary>
        Searching,

        /// <summary>Seen and followed.</summary>
        Tracked,

        /// <summary>Hidden, carried by its link.</summary>
        Inferred,

        /// <summary>Hidden, carried by its motion.</summary>
        Predicted,

        /// <summary>Was found, is no more; no pose.</summary>
        Lost,
    }

    /// <summary>The API's names of the statuses.</summary>
    public static class PartStatusNames
    {
        /// <summary>The status of a name.</summary>
        /// <exception cref="JsonFormatException">There is none of that name.</exception>
        public static PartStatus Parse(string name)
        {
            switch (name)
            {
                case "searching":
                    return PartStatus.Searching;
                case "tracked":
                    return PartStatus.Tracked;
                case "inferred":
                    return PartStatus.Inferred;
                case "predicted":
                    return PartStatus.Predicted;
                case "lost":
                    return PartStatus.Lost;
                default:
                    throw new JsonFormatException("There is no part status '" + name + "'.");
            }
        }
    }
}
