using System;
using System.Text;

namespace Snapfit.Tests
{
    /// <summary>Snapshots: read as they are, into objects that are used again.</summary>
    public static class SnapshotTests
    {
        /// <summary>Everything that the contract has.</summary>
        public static void ReadsEverything()
        {
            PoseSnapshot snapshot = Samples.Read(Samples.Snapshot);
            Check.Equal("bench-1", snapshot.Station);
            Check.Equal("clamp", snapshot.Asset);
            Check.Equal("boot-a", snapshot.BootId);
            Check.Equal(8L, snapshot.Seq);
            Check.Equal(1795366685452300L, snapshot.CapturedAtUs);
            Check.Equal(Convention.Unity, snapshot.Convention);
            Check.Equal(18452L, snapshot.AgeUs);
            PartPose jaw = snapshot.Find("jaw");
            Check.That(jaw.HasPose && jaw.HasVelocity && jaw.HasCovariance, "has all");
            Check.Near(new Vec3(0.1, -0.2, 0.3), jaw.Pose.Position, 0, "position");
            Check.Near(new Quat(0, 0.6, 0, 0.8), jaw.Pose.Orientation, 1e-12, "orientation");
            Check.Near(35e-6, jaw.Covariance[35], 1e-18, "covariance");
            Check.Near(new Vec3(0, 0, 1), jaw.AngularVelocity, 0, "angular");
            Check.Equal("base", jaw.LinkedTo);
            Check.That(snapshot.Find("cup") == null, "no such part");
        }

        /// <summary>A lost part has nothing to show.</summary>
        public static void ReadsALostPart()
        {
            PartPose cap = Samples.Read(Samples.Snapshot).Find("cap");
            Check.Equal(PartStatus.Lost, cap.Status);
            Check.That(!cap.HasPose && !cap.HasVelocity && !cap.HasCovariance, "has nothing");
            Check.That(cap.LastSeenAtUs == null && cap.LinkedTo == null, "nulls");
        }

        /// <summary>The assembly in it.</summary>
        public static void ReadsTheAssembly()
        {
            PoseSnapshot snapshot = Samples.Read(Samples.Snapshot);
            Check.That(snapshot.HasAssembly, "has one");
            AssemblySummary assembly = snapshot.Assembly;
            Check.Equal("jaw-mounted", assembly.State);
            Check.Equal("screw-bolt", assembly.NextSteps[0]);
            Check.Equal("wrong_place", assembly.Misassemblies[0].Kind);
            Check.Near(0.012, assembly.Misassemblies[0].TranslationM.Value, 0, "how far");
            Check.That(assembly.Misassemblies[0].RotationRad == null, "no rotation");
            Check.Equal(3L, assembly.Revision);
        }

        /// <summary>Nothing is left of the snapshot before.</summary>
        public static void ForgetsTheOneBefore()
        {
            SnapshotReader reader = new SnapshotReader();
            PoseSnapshot snapshot = new PoseSnapshot();
            byte[] first = Encoding.UTF8.GetBytes(Samples.Snapshot);
            reader.Read(first, first.Length, snapshot);
            byte[] next = Encoding.UTF8.GetBytes("{\"boot_id\":\"b\",\"seq\":1,"
                + "\"frame\":\"camera\",\"parts\":[{\"part\":\"jaw\",\"status\":\"searching\"}],"
                + "\"assembly\":null}");
            reader.Read(next, next.Length, snapshot);
            Check.Equal(1, snapshot.PartCount);
            PartPose jaw = snapshot[0];
            Check.That(!jaw.HasPose && !jaw.HasVelocity && !jaw.HasCovariance, "nothing left");
            Check.That(jaw.LinkedTo == null && !snapshot.HasAssembly, "nothing left");
            Check.Throws<ArgumentOutOfRangeException>(() => Ignore(snapshot[1]), "place");
        }

        /// <summary>What is no snapshot is refused, and says why.</summary>
        public static void RefusesWhatIsNone()
        {
            Check.Throws<JsonFormatException>(() => Samples.Read("{}"), "boot_id");
            Check.Throws<JsonFormatException>(() => Samples.Read("<html>"), "expected");
            string three = Samples.Snapshot.Replace("[0,0.6,0,0.8]", "[0,0.6,0]");
            Check.Throws<JsonFormatException>(() => Samples.Read(three), "3 numbers where 4");
            string odd = Samples.Snapshot.Replace("\"tracked\"", "\"dreamt\"");
            Check.Throws<JsonFormatException>(() => Samples.Read(odd), "dreamt");
        }

        /// <summary>Thirty a second for hours: reading allocates nothing. Without misassemblies,
        /// which are rare.</summary>
        public static void ReadingAllocatesNothing()
        {
            string calm = Samples.Snapshot.Replace("{\"x\":[1,{}]}", "[]");
            int begin = calm.IndexOf("[{\"part\":\"pin\"");
            calm = calm.Remove(begin, calm.IndexOf("],\"decided_by\"") - begin).Insert(begin, "[");
            byte[] bytes = Encoding.UTF8.GetBytes(calm);
            SnapshotReader reader = new SnapshotReader();
            PoseSnapshot snapshot = new PoseSnapshot();
            PosePlayer player = new PosePlayer();
            reader.Read(bytes, bytes.Length, snapshot);
            player.Add(snapshot);
            GC.Collect();
            int before = GC.CollectionCount(0);
            for (int turn = 0; turn < 100000; turn++)
            {
                reader.Read(bytes, bytes.Length, snapshot);
                player.Add(snapshot);
                player.Sample("jaw", snapshot.CapturedAtUs + 50000);
            }
            // A young generation holds about 4 MB: 40 bytes a turn would fill it.
            Check.Equal(before, GC.CollectionCount(0), "collections");
        }

        private static void Ignore(PartPose part)
        {
        }
    }
}
