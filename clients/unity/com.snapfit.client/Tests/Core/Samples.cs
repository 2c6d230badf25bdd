using System.Globalization;
using System.Text;

namespace Snapfit.Tests
{
    /// <summary>Snapshots for tests.</summary>
    public static class Samples
    {
        /// <summary>A snapshot as the server writes it: the jaw moves, the cap is lost.</summary>
        public static readonly string Snapshot =
            "{\"station\":\"bench-1\",\"asset\":\"clamp\",\"boot_id\":\"boot-a\",\"seq\":8,"
            + "\"stale\":false,\"captured_at_us\":1795366685452300,"
            + "\"published_at_us\":1795366685466658,\"frame\":\"anchor:h\","
            + "\"convention\":\"unity\",\"from_the_future\":{\"x\":[1,{}]},\"parts\":["
            + "{\"part\":\"jaw\",\"status\":\"tracked\",\"confidence\":0.97,"
            + "\"position\":[0.1,-0.2,0.3],\"orientation\":[0,0.6,0,0.8],\"covariance\":"
            + Covariance() + ",\"linear_velocity\":[0.1,0,0],\"angular_velocity\":[0,0,1],"
            + "\"linked_to\":\"base\",\"last_seen_at_us\":1795366685452300},"
            + "{\"part\":\"cap\",\"status\":\"lost\",\"confidence\":0,\"position\":null,"
            + "\"orientation\":null,\"covariance\":null,\"linear_velocity\":null,"
            + "\"angular_velocity\":null,\"linked_to\":null,\"last_seen_at_us\":null}],"
            + "\"assembly\":{\"state\":\"jaw-mounted\",\"confidence\":0.9,"
            + "\"finished_steps\":[\"mount-jaw\"],\"next_steps\":[\"screw-bolt\"],"
            + "\"misassemblies\":[{\"part\":\"pin\",\"parent\":\"base\",\"kind\":\"wrong_place\","
            + "\"translation_m\":0.012,\"rotation_rad\":null}],\"decided_by\":\"tracking\","
            + "\"since_us\":1795366680000000,\"revision\":3},\"age_us\":18452}";

        /// <summary>A snapshot with one part, the jaw.</summary>
        public static PoseSnapshot Of(
            string bootId, long seq, long capturedAtUs, bool isStale, Vec3? position, Vec3 linear,
            Vec3 angular)
        {
            string vector = position == null ? "null" : Write(position.Value);
            string json = "{\"station\":\"s\",\"asset\":null,\"boot_id\":\"" + bootId
                + "\",\"seq\":" + seq + ",\"stale\":" + (isStale ? "true" : "false")
                + ",\"captured_at_us\":" + capturedAtUs + ",\"published_at_us\":" + capturedAtUs
                + ",\"frame\":\"camera\",\"convention\":\"unity\",\"parts\":[{\"part\":\"jaw\","
                + "\"status\":\"" + (position == null ? "lost" : "tracked")
                + "\",\"confidence\":0.9,\"position\":" + vector + ",\"orientation\":"
                + (position == null ? "null" : "[0,0,0,1]") + ",\"covariance\":null,"
                + "\"linear_velocity\":" + Write(linear) + ",\"angular_velocity\":"
                + Write(angular) + ",\"linked_to\":null,\"last_seen_at_us\":null}],"
                + "\"assembly\":null,\"age_us\":0}";
            return Read(json);
        }

        /// <summary>Read into a new object.</summary>
        public static PoseSnapshot Read(string json)
        {
            PoseSnapshot snapshot = new PoseSnapshot();
            byte[] bytes = Encoding.UTF8.GetBytes(json);
            new SnapshotReader().Read(bytes, bytes.Length, snapshot);
            return snapshot;
        }

        private static string Write(Vec3 v)
        {
            return string.Format(
                CultureInfo.InvariantCulture, "[{0:R},{1:R},{2:R}]", v.X, v.Y, v.Z);
        }

        private static string Covariance()
        {
            StringBuilder text = new StringBuilder("[");
            for (int place = 0; place < PartPose.CovarianceLength; place++)
            {
                text.Append(place == 0 ? "" : ",").Append(place).Append("e-6");
            }
            return text.Append(']').ToString();
        }
    }
}
