namespace Snapfit
{
    /// <summary>How far two poses are apart.</summary>
    public struct Apart
    {
        /// <summary>Metres.</summary>
        public double TranslationM;

        /// <summary>Radians.</summary>
        public double RotationRad;

        internal static Apart? From(JsonValue json)
        {
            if (json.IsNull)
            {
                return null;
            }
            return new Apart
            {
                TranslationM = json["translation_m"].AsDouble(),
                RotationRad = json["rotation_rad"].AsDouble(),
            };
        }
    }

    /// <summary>How a client's world lies against the station's camera.</summary>
    public sealed class Anchor
    {
        private Anchor(JsonValue json)
        {
            Id = json["anchor"].AsString();
            Frame = json["frame"].AsString();
            Convention = ConventionNames.Parse(json["convention"].AsString());
            Aligned = json["aligned"].AsBool();
            WorldFromCamera = JsonLists.PoseOrNull(json["world_from_camera"]);
            Samples = (int)json["samples"].AsLong();
            Residual = Apart.From(json["residual"]) ?? default(Apart);
            CameraResidual = Apart.From(json["camera_residual"]);
            Drift = Apart.From(json["drift"]);
            Drifting = json["drifting"].AsBool();
            ExpiresAtUs = json["expires_at_us"].AsLong();
        }

        /// <summary>The name that the client gave it.</summary>
        public string Id { get; private set; }

        /// <summary>What to ask for as frame of poses and steps.</summary>
        public string Frame { get; private set; }

        /// <summary>The axes of the poses here.</summary>
        public Convention Convention { get; private set; }

        /// <summary>Whether client and camera have both seen the board.</summary>
        public bool Aligned { get; private set; }

        /// <summary>Metres; null until then.</summary>
        public RigidPose? WorldFromCamera { get; private set; }

        /// <summary>How many of the client's poses are averaged, at most 20.</summary>
        public int Samples { get; private set; }

        /// <summary>Their root mean square around the average.</summary>
        public Apart Residual { get; private set; }

        /// <summary>That of the camera's own; null until it has seen the board.</summary>
        public Apart? CameraResidual { get; private set; }

        /// <summary>Between where client and camera see the board now, at the board; null until
        /// both do.</summary>
        public Apart? Drift { get; private set; }

        /// <summary>Whether that is more than 10 mm or 2 degrees.</summary>
        public bool Drifting { get; private set; }

        /// <summary>When it is forgotten if it is not put again, microseconds of the server's
        /// time.</summary>
        public long ExpiresAtUs { get; private set; }

        /// <summary>From an answer's JSON.</summary>
        /// <exception cref="JsonFormatException">Something is missing.</exception>
        public static Anchor From(JsonValue json)
        {
            return new Anchor(json);
        }
    }
}
