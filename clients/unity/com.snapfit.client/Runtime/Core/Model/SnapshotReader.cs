namespace Snapfit
{
    /// <summary>Reads the JSON of a snapshot into an object that is used again. Members that this
    /// client does not know are passed over.</summary>
    public sealed class SnapshotReader
    {
        private readonly JsonReader json = new JsonReader();
        private readonly double[] numbers = new double[4];

        /// <summary>Reads one.</summary>
        /// <param name="bytes">A PoseSnapshot of the contract, UTF-8.</param>
        /// <param name="count">How many of the bytes belong to it.</param>
        /// <param name="into">What it had is overwritten.</param>
        /// <exception cref="JsonFormatException">It is none.</exception>
        public void Read(byte[] bytes, int count, PoseSnapshot into)
        {
            json.Reset(bytes, count);
            into.Clear();
            string name;
            json.BeginObject();
            while (json.NextName(out name))
            {
                Member(name, into);
            }
            json.End();
            if (into.BootId == null || into.Seq < 1 || into.Frame == null)
            {
                throw new JsonFormatException("The answer is no snapshot: boot_id, seq or frame "
                    + "is missing. Does snapfit answer at this address?");
            }
        }

        private void Member(string name, PoseSnapshot into)
        {
            switch (name)
            {
                case "station":
                    into.Station = json.ReadString();
                    break;
                case "asset":
                    into.Asset = JsonFields.StringOrNull(json);
                    break;
                case "boot_id":
                    into.BootId = json.ReadString();
                    break;
                case "seq":
                    into.Seq = json.ReadLong();
                    break;
                case "stale":
                    into.Stale = json.ReadBool();
                    break;
                case "frame":
                    into.Frame = json.ReadString();
                    break;
                case "convention":
                    into.Convention = ConventionNames.Parse(json.ReadString());
                    break;
                case "parts":
                    Parts(into);
                    break;
                case "assembly":
                    into.HasAssembly = !json.TakeNull();
                    if (into.HasAssembly)
                    {
                        AssemblyReader.Read(json, into.Assembly);
                    }
                    break;
                default:
                    Time(name, into);
                    break;
            }
        }

        private void Time(string name, PoseSnapshot into)
        {
            switch (name)
            {
                case "captured_at_us":
                    into.CapturedAtUs = json.ReadLong();
                    break;
                case "published_at_us":
                    into.PublishedAtUs = json.ReadLong();
                    break;
                case "age_us":
                    into.AgeUs = json.ReadLong();
                    break;
                default:
                    json.Skip();
                    break;
            }
        }

        private void Parts(PoseSnapshot into)
        {
            json.BeginArray();
            while (json.NextItem())
            {
                PartPose part = into.Add();
                bool hasPosition = false;
                bool hasOrientation = false;
                Vec3 position = Vec3.Zero;
                Quat orientation = Quat.Identity;
                string name;
                json.BeginObject();
                while (json.NextName(out name))
                {
                    if (name == "position")
                    {
                        hasPosition = TryVector(out position);
                    }
                    else if (name == "orientation" && (hasOrientation = !json.TakeNull()))
                    {
                        JsonFields.Numbers(json, numbers, 4);
                        orientation = new Quat(numbers[0], numbers[1], numbers[2], numbers[3]);
                    }
                    else if (name != "orientation")
                    {
                        PartMember(name, part);
                    }
                }
                part.HasPose = hasPosition && hasOrientation;
                part.Pose = new RigidPose(position, orientation);
            }
        }

        private void PartMember(string name, PartPose part)
        {
            Vec3 vector;
            switch (name)
            {
                case "part":
                    part.Part = json.ReadString();
                    break;
                case "status":
                    part.Status = PartStatusNames.Parse(json.ReadString());
                    break;
                case "confidence":
                    part.Confidence = json.ReadDouble();
                    break;
                case "covariance":
                    part.HasCovariance = !json.TakeNull();
                    if (part.HasCovariance)
                    {
                        JsonFields.Numbers(json, part.Covariance, PartPose.CovarianceLength);
                    }
                    break;
                case "linear_velocity":
                    part.HasVelocity |= TryVector(out vector);
                    part.LinearVelocity = vector;
                    break;
                case "angular_velocity":
                    part.HasVelocity |= TryVector(out vector);
                    part.AngularVelocity = vector;
                    break;
                case "linked_to":
                    part.LinkedTo = JsonFields.StringOrNull(json);
                    break;
                case "last_seen_at_us":
                    part.LastSeenAtUs = json.TakeNull() ? (long?)null : json.ReadLong();
                    break;
                default:
                    json.Skip();
                    break;
            }
        }

        private bool TryVector(out Vec3 vector)
        {
            vector = Vec3.Zero;
            if (json.TakeNull())
            {
                return false;
            }
            JsonFields.Numbers(json, numbers, 3);
            vector = new Vec3(numbers[0], numbers[1], numbers[2]);
            return true;
        }
    }
}
