namespace Snapfit
{
    /// <summary>What a client tells of a board that it sees.</summary>
    public sealed class AnchorWish
    {
        /// <summary>A board's pose in the client's world.</summary>
        /// <param name="worldFromMarker">Metres. The board's frame has its origin in its middle;
        /// in <see cref="Convention.OpenCv"/> x right, y down, z into it, as it is read; in
        /// <see cref="Convention.Unity"/> x right, y up the page, z into it.</param>
        /// <param name="convention">The axes of both world and board.</param>
        public AnchorWish(RigidPose worldFromMarker, Convention convention)
        {
            WorldFromMarker = worldFromMarker;
            Convention = convention;
        }

        /// <summary>The board's pose in the client's world, metres.</summary>
        public RigidPose WorldFromMarker { get; private set; }

        /// <summary>The axes of both.</summary>
        public Convention Convention { get; private set; }

        /// <summary>What both look at; null for the board that snapfit prints.</summary>
        public Board Board { get; set; }

        /// <summary>Forget what was put before: the world was found anew.</summary>
        public bool Restart { get; set; }

        /// <summary>The anchor expires when it is not put again for so long, seconds.</summary>
        public double TtlS { get; set; } = 3600;

        /// <summary>The body of a request.</summary>
        public string ToJson()
        {
            Vec3 at = WorldFromMarker.Position;
            Quat turn = WorldFromMarker.Orientation.Normalised;
            JsonWriter json = new JsonWriter().BeginObject()
                .Member("convention", Convention.Name())
                .Member("world_from_marker", new RigidPose(at, turn))
                .Member("restart", Restart)
                .Member("ttl_s", TtlS);
            if (Board != null)
            {
                Board.Write(json);
            }
            return json.EndObject().ToString();
        }
    }

    /// <summary>What camera and client both look at.</summary>
    public abstract class Board
    {
        internal abstract void Write(JsonWriter json);
    }

    /// <summary>An ArUco marker.</summary>
    public sealed class ArucoMarker : Board
    {
        private readonly int id;
        private readonly double sizeM;
        private readonly string dictionary;

        /// <summary>A marker of a dictionary.</summary>
        /// <param name="id">Its number.</param>
        /// <param name="sizeM">Edge of the black square, metres; the distance is as wrong as it
        /// is.</param>
        /// <param name="dictionary">DICT_4X4_50, DICT_5X5_100, DICT_6X6_250 or
        /// DICT_APRILTAG_36H11.</param>
        public ArucoMarker(int id, double sizeM, string dictionary = "DICT_4X4_50")
        {
            this.id = id;
            this.sizeM = sizeM;
            this.dictionary = dictionary;
        }

        internal override void Write(JsonWriter json)
        {
            json.BeginObject("board").Member("kind", "aruco").Member("id", id)
                .Member("size_m", sizeM).Member("dictionary", dictionary).EndObject();
        }
    }

    /// <summary>A QR code.</summary>
    public sealed class QrCode : Board
    {
        private readonly string text;
        private readonly double sizeM;

        /// <summary>A code that says something.</summary>
        /// <param name="text">What it says.</param>
        /// <param name="sizeM">Edge of the code without its quiet zone, metres.</param>
        public QrCode(string text, double sizeM)
        {
            this.text = text;
            this.sizeM = sizeM;
        }

        internal override void Write(JsonWriter json)
        {
            json.BeginObject("board").Member("kind", "qr").Member("text", text)
                .Member("size_m", sizeM).EndObject();
        }
    }
}
