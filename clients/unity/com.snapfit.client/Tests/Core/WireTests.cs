using System;
using System.Collections.Generic;
using System.Text;

namespace Snapfit.Tests
{
    /// <summary>Events, problems, addresses and requests, as they go over the wire.</summary>
    public static class WireTests
    {
        /// <summary>Events with ids, comments between them, lines of both kinds.</summary>
        public static void PutsEventsTogether()
        {
            SseParser parser = new SseParser();
            List<string> got = Feed(parser, "retry: 1000\n\n: here\n\nid: x-1\nevent: stale\n"
                + "data: {\"a\":1}\n\nid: x-2\r\nevent:recovered\r\ndata: one\r\ndata:two\r\n\r\n");
            Check.Equal("stale={\"a\":1}|recovered=one\ntwo", string.Join("|", got.ToArray()));
            Check.Equal("x-2", parser.LastId);
        }

        /// <summary>What was not complete when the connection broke does not count.</summary>
        public static void ForgetsHalfAnEvent()
        {
            SseParser parser = new SseParser();
            Feed(parser, "id: x-1\nevent: stale\ndata: {}\n\n"
                + "id: x-2\nevent: part_lost\ndata: {\"p");
            parser.Reset();
            Check.Equal("x-1", parser.LastId);
            List<string> got = Feed(parser, "event: recovered\ndata: {}\n\n");
            Check.Equal("recovered={}", string.Join("|", got.ToArray()));
            Check.Equal("x-1", parser.LastId);
        }

        /// <summary>An id alone is no event, but says where to go on.</summary>
        public static void TakesAnIdAlone()
        {
            SseParser parser = new SseParser();
            Check.Equal(0, Feed(parser, "retry: 1000\nid: x-7\n\n: here\n\n").Count);
            Check.Equal("x-7", parser.LastId);
        }

        /// <summary>What the server says is in the exception.</summary>
        public static void ProblemsTellAll()
        {
            string body = "{\"type\":\"urn:snapfit:problem:unknown-part\",\"title\":\"Not Found\","
                + "\"status\":404,\"detail\":\"Station bench-1 has no part 'jew'.\","
                + "\"instance\":\"/v1/poses/jew\",\"parts\":[\"base\",\"jaw\"]}";
            byte[] bytes = Encoding.UTF8.GetBytes(body);
            ProblemException problem = ProblemException.From(404, bytes, bytes.Length, 2);
            Check.Equal(404, problem.Status);
            Check.Equal("unknown-part", problem.Kind);
            Check.Equal("Not Found", problem.Title);
            Check.Equal("Station bench-1 has no part 'jew'.", problem.Detail);
            Check.Equal("/v1/poses/jew", problem.Instance);
            Check.Equal("jaw", problem.Names("parts")[1]);
            Check.Equal(0, problem.Names("states").Count);
            Check.Near(2, problem.RetryAfterS.Value, 0, "retry");
            Check.That(problem.Message.Contains("jew"), "message");
        }

        /// <summary>A proxy's error page is no problem of snapfit's, and says so.</summary>
        public static void OthersErrorsAreTold()
        {
            byte[] bytes = Encoding.UTF8.GetBytes("<html>Bad Gateway</html>");
            ProblemException problem = ProblemException.From(502, bytes, bytes.Length, null);
            Check.Equal(502, problem.Status);
            Check.That(problem.Detail.Contains("Does snapfit answer"), problem.Detail);
        }

        /// <summary>Addresses are checked when they are given.</summary>
        public static void AddressesAreChecked()
        {
            foreach (string wrong in new[] { "", "bench", "192.168.1.20:8000", "ftp://x", null })
            {
                Check.Throws<ArgumentException>(() => new SnapfitOptions(wrong), "address");
            }
            SnapfitOptions options = new SnapfitOptions("http://bench.local:8000/v1/");
            Check.Equal("http://bench.local:8000/", options.Address.ToString());
        }

        /// <summary>Paths of the only station and of a named one, names escaped.</summary>
        public static void PathsAreEscaped()
        {
            SnapfitOptions options = new SnapfitOptions("http://h")
            {
                Frame = "anchor:a b", Convention = Convention.RosOptical,
            };
            Check.Equal("/v1/poses", options.StationPath("/poses"));
            options.Station = "bench 1/left";
            Check.Equal("/v1/stations/bench%201%2Fleft/poses", options.StationPath("/poses"));
            Check.Equal("?convention=ros_optical&frame=anchor%3Aa%20b", options.ViewQuery);
        }

        /// <summary>What is put as an anchor.</summary>
        public static void AnAnchorIsWritten()
        {
            RigidPose pose = new RigidPose(new Vec3(0.1, 0.9, 0.6), new Quat(0, 0, 0, 2));
            JsonValue json = JsonValue.Parse(new AnchorWish(pose, Convention.Unity)
            {
                Board = new ArucoMarker(7, 0.25), Restart = true,
            }.ToJson());
            Check.Equal("unity", json["convention"].AsString());
            Check.Near(pose.Position, JsonLists.Pose(json["world_from_marker"]).Position, 0, "at");
            Check.Near(1, JsonLists.Pose(json["world_from_marker"]).Orientation.W, 0, "unit");
            Check.Equal(7L, json["board"]["id"].AsLong());
            Check.That(json["restart"].AsBool(), "restart");
            JsonValue qr = JsonValue.Parse(new AnchorWish(pose, Convention.Unity)
            {
                Board = new QrCode("bench \"1\"", 0.2),
            }.ToJson());
            Check.Equal("bench \"1\"", qr["board"]["text"].AsString());
        }

        private static List<string> Feed(SseParser parser, string text)
        {
            List<string> got = new List<string>();
            foreach (byte each in Encoding.UTF8.GetBytes(text))
            {
                if (parser.Take(each))
                {
                    got.Add(parser.Kind + "=" + parser.Data);
                }
            }
            return got;
        }
    }
}
