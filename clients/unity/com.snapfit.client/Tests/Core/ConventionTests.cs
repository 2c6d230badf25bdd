using System.Collections.Generic;
using System.IO;

namespace Snapfit.Tests
{
    /// <summary>Conventions against the golden vectors, which are made from the axes alone and
    /// which the server is tested with too.</summary>
    public static class ConventionTests
    {
        private const double Rounding = 2e-12;
        private const double Angle = 1e-10;

        private static readonly Convention[] All =
        {
            Convention.OpenCv, Convention.OpenXr, Convention.Unity, Convention.Ros,
            Convention.RosOptical,
        };

        private static readonly string[] Vectors =
        {
            "linear_velocity", "vertex_in_body", "vertex_in_frame",
        };

        private static readonly string[] Frames = { "camera", "anchor" };

        /// <summary>Every case from every convention into every other one.</summary>
        public static void MapsEveryGoldenVector()
        {
            int compared = 0;
            foreach (JsonValue frame in GoldenFrames())
            {
                foreach (Convention from in All)
                {
                    foreach (Convention to in All)
                    {
                        Compare(frame[from.Name()], frame[to.Name()], new ConventionMap(from, to));
                        compared++;
                    }
                }
            }
            Check.Equal(8 * 2 * 25, compared, "comparisons");
        }

        /// <summary>The check that finds every mistake: turn, add, compare.</summary>
        public static void APoseBringsTheVertexThere()
        {
            foreach (JsonValue frame in GoldenFrames())
            {
                foreach (Convention convention in All)
                {
                    JsonValue golden = frame[convention.Name()];
                    Vec3 there = JsonLists.Pose(golden)
                        .Apply(JsonLists.Vector(golden["vertex_in_body"]));
                    Check.Near(
                        JsonLists.Vector(golden["vertex_in_frame"]), there, Rounding, "vertex");
                }
            }
        }

        /// <summary>A pose in the camera's frame and the anchor give the pose in the anchor's.
        /// </summary>
        public static void ProductsCancelInEveryConvention()
        {
            JsonValue golden = Golden();
            foreach (Convention convention in All)
            {
                string name = convention.Name();
                RigidPose anchor = JsonLists.Pose(golden["anchor_from_camera"][name]);
                foreach (JsonValue each in golden["cases"].Items)
                {
                    RigidPose product = anchor * JsonLists.Pose(each["camera"][name]);
                    RigidPose wanted = JsonLists.Pose(each["anchor"][name]);
                    Check.Near(wanted.Position, product.Position, Rounding, "position");
                    Check.Near(wanted.Orientation, product.Orientation, Angle, "orientation");
                }
            }
        }

        /// <summary>Names of the API, there and back.</summary>
        public static void NamesGoThereAndBack()
        {
            JsonValue known = Golden()["conventions"];
            foreach (Convention convention in All)
            {
                Check.That(!known.Find(convention.Name()).IsNull, convention.Name());
                Check.Equal(convention, ConventionNames.Parse(convention.Name()));
            }
            Check.Throws<JsonFormatException>(() => ConventionNames.Parse("maya"), "maya");
        }

        /// <summary>The golden file, also for other tests.</summary>
        public static JsonValue Golden()
        {
            string text = File.ReadAllText(Path.Combine(TestList.Folder, "conventions.json"));
            return JsonValue.Parse(text);
        }

        private static IEnumerable<JsonValue> GoldenFrames()
        {
            foreach (JsonValue each in Golden()["cases"].Items)
            {
                foreach (string frame in Frames)
                {
                    yield return each[frame];
                }
            }
        }

        private static void Compare(JsonValue from, JsonValue to, ConventionMap map)
        {
            RigidPose mapped = map.Pose(JsonLists.Pose(from));
            RigidPose wanted = JsonLists.Pose(to);
            Check.Near(wanted.Position, mapped.Position, Rounding, "position");
            Check.Near(wanted.Orientation, mapped.Orientation, Angle, "orientation");
            foreach (string name in Vectors)
            {
                Vec3 vector = map.Vector(JsonLists.Vector(from[name]));
                Check.Near(JsonLists.Vector(to[name]), vector, Rounding, name);
            }
            Vec3 turn = map.Turn(JsonLists.Vector(from["angular_velocity"]));
            Check.Near(JsonLists.Vector(to["angular_velocity"]), turn, Rounding, "angular");
            double[] covariance = new double[PartPose.CovarianceLength];
            map.Covariance(
                JsonLists.Numbers(from["covariance"], covariance.Length), covariance);
            double[] golden = JsonLists.Numbers(to["covariance"], covariance.Length);
            for (int place = 0; place < covariance.Length; place++)
            {
                Check.Near(golden[place], covariance[place], Rounding, "covariance " + place);
            }
        }
    }
}
