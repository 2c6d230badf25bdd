using System;

namespace Snapfit
{
    /// <summary>Along which axes an answer of the server is given.</summary>
    public enum Convention
    {
        /// <summary>x right, y down, z forward: what snapfit computes in.</summary>
        OpenCv,

        /// <summary>x right, y up, z backward: OpenXR, OpenGL; glTF files.</summary>
        OpenXr,

        /// <summary>x right, y up, z forward, left-handed.</summary>
        Unity,

        /// <summary>x forward, y left, z up: body frames of ROS.</summary>
        Ros,

        /// <summary>x right, y down, z forward: ROS frames named _optical.</summary>
        RosOptical,
    }

    /// <summary>The API's names of the conventions.</summary>
    public static class ConventionNames
    {
        private static readonly string[] Names =
        {
            "opencv", "openxr", "unity", "ros", "ros_optical",
        };

        /// <summary>As the API writes it.</summary>
        public static string Name(this Convention convention)
        {
            return Names[(int)convention];
        }

        /// <summary>The convention of a name.</summary>
        /// <exception cref="JsonFormatException">There is none of that name.</exception>
        public static Convention Parse(string name)
        {
            int place = Array.IndexOf(Names, name);
            if (place < 0)
            {
                throw new JsonFormatException(
                    "There is no convention '" + name + "'; this client knows "
                    + string.Join(", ", Names) + ".");
            }
            return (Convention)place;
        }
    }
}
