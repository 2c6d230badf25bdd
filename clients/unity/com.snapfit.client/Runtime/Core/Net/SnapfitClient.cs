using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>What can be asked of a server, one request a method. Poses that keep coming are
    /// the business of <see cref="PoseFeed"/>.</summary>
    /// <remarks>Every method throws <see cref="ProblemException"/> where the server says no,
    /// <see cref="UnreachableException"/> where it does not answer, and
    /// <see cref="JsonFormatException"/> where something else answers.</remarks>
    public sealed class SnapfitClient : IDisposable
    {
        private readonly SnapfitOptions options;

        /// <summary>For the server of the options.</summary>
        public SnapfitClient(SnapfitOptions options)
        {
            this.options = options;
            Channel = new HttpChannel(options);
        }

        /// <summary>What it speaks through.</summary>
        public HttpChannel Channel { get; private set; }

        /// <summary>All workbenches of the server.</summary>
        public async Task<List<StationInfo>> GetStationsAsync(CancellationToken token)
        {
            JsonValue json = await GetAsync("/v1/stations", token).ConfigureAwait(false);
            return JsonLists.Of(json["stations"], StationInfo.From);
        }

        /// <summary>The latest poses.</summary>
        public async Task<PoseSnapshot> GetPosesAsync(CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            string path = options.StationPath("/poses") + options.ViewQuery;
            await Channel.GetAsync(path, buffer, 0, token).ConfigureAwait(false);
            PoseSnapshot snapshot = new PoseSnapshot();
            new SnapshotReader().Read(buffer.Bytes, buffer.Count, snapshot);
            return snapshot;
        }

        /// <summary>The assembly state.</summary>
        public async Task<AssemblyAnswer> GetAssemblyAsync(CancellationToken token)
        {
            string path = options.StationPath("/assembly");
            return AssemblyAnswer.From(await GetAsync(path, token).ConfigureAwait(false));
        }

        /// <summary>All steps, in the order of the asset.</summary>
        public async Task<StepAnswer> GetStepsAsync(CancellationToken token)
        {
            string path = options.StationPath("/steps") + options.ViewQuery;
            return StepAnswer.From(await GetAsync(path, token).ConfigureAwait(false));
        }

        /// <summary>The step that can be taken now. Where nothing is left to do it throws a
        /// problem of the kind assembly-finished.</summary>
        public Task<StepAnswer> GetCurrentStepAsync(CancellationToken token)
        {
            return GetStepAsync("current", token);
        }

        /// <summary>The step of a name.</summary>
        public async Task<StepAnswer> GetStepAsync(string step, CancellationToken token)
        {
            string path = options.StationPath("/steps/" + Uri.EscapeDataString(step))
                + options.ViewQuery;
            return StepAnswer.From(await GetAsync(path, token).ConfigureAwait(false));
        }

        /// <summary>The mesh of an asset's part: binary glTF in glTF's own axes, metres.
        /// </summary>
        public async Task<byte[]> GetMeshAsync(string asset, string part, CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            await Channel.GetAsync(MeshPath(asset, part), buffer, 0, token).ConfigureAwait(false);
            return buffer.ToArray();
        }

        /// <summary>Where that mesh is, for importers that load it themselves.</summary>
        public Uri MeshAddress(string asset, string part)
        {
            return new Uri(options.Address, MeshPath(asset, part));
        }

        /// <summary>The first assembly state, and all parts are looked for again.</summary>
        public Task<CommandResult> ResetAsync(CancellationToken token)
        {
            return CommandAsync("POST", "/reset", null, token);
        }

        /// <summary>Parts are looked for again; the state stays.</summary>
        /// <param name="parts">Their names; none for all.</param>
        /// <param name="token">Ends it.</param>
        public Task<CommandResult> ReinitialiseAsync(string[] parts, CancellationToken token)
        {
            string json = new JsonWriter().BeginObject().Member("parts", parts).EndObject()
                .ToString();
            return CommandAsync("POST", "/reinitialise", json, token);
        }

        /// <summary>An operator says which assembly state holds.</summary>
        public Task<CommandResult> SetStateAsync(string state, CancellationToken token)
        {
            string json = new JsonWriter().BeginObject().Member("state", state).EndObject()
                .ToString();
            return CommandAsync("PUT", "/assembly/state", json, token);
        }

        /// <summary>Tells where this device sees the board that the camera sees too.</summary>
        /// <param name="id">The anchor's name: this device's choice.</param>
        /// <param name="wish">The board's pose in this device's world.</param>
        /// <param name="token">Ends it.</param>
        public async Task<Anchor> PutAnchorAsync(
            string id, AnchorWish wish, CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            await Channel.SendAsync("PUT", AnchorPath(id), wish.ToJson(), buffer, token)
                .ConfigureAwait(false);
            return Anchor.From(JsonValue.Parse(buffer.Bytes, buffer.Count));
        }

        /// <summary>How this device's world lies against the camera.</summary>
        public async Task<Anchor> GetAnchorAsync(string id, CancellationToken token)
        {
            string path = AnchorPath(id) + "?convention=" + options.Convention.Name();
            return Anchor.From(await GetAsync(path, token).ConfigureAwait(false));
        }

        /// <summary>Forgets it.</summary>
        public Task DeleteAnchorAsync(string id, CancellationToken token)
        {
            return Channel.SendAsync("DELETE", AnchorPath(id), null, new ResponseBuffer(), token);
        }

        /// <summary>Four stamps for <see cref="ClockSync"/>; the client's are of
        /// <see cref="MonotonicClock"/>.</summary>
        public async Task<ClockSample> GetTimeAsync(CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            long sentUs = MonotonicClock.NowUs;
            await Channel.GetAsync("/v1/time", buffer, 0, token).ConfigureAwait(false);
            long receivedUs = MonotonicClock.NowUs;
            JsonValue json = JsonValue.Parse(buffer.Bytes, buffer.Count);
            return new ClockSample(
                sentUs, json["received_at_us"].AsLong(), json["sent_at_us"].AsLong(), receivedUs);
        }

        /// <summary>Closes its connections.</summary>
        public void Dispose()
        {
            Channel.Dispose();
        }

        private static string MeshPath(string asset, string part)
        {
            return "/v1/assets/" + Uri.EscapeDataString(asset) + "/parts/"
                + Uri.EscapeDataString(part) + ".glb";
        }

        private string AnchorPath(string id)
        {
            return options.StationPath("/anchors/" + Uri.EscapeDataString(id));
        }

        private async Task<JsonValue> GetAsync(string path, CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            await Channel.GetAsync(path, buffer, 0, token).ConfigureAwait(false);
            return JsonValue.Parse(buffer.Bytes, buffer.Count);
        }

        private async Task<CommandResult> CommandAsync(
            string method, string below, string json, CancellationToken token)
        {
            ResponseBuffer buffer = new ResponseBuffer();
            await Channel.SendAsync(method, options.StationPath(below), json, buffer, token)
                .ConfigureAwait(false);
            return CommandResult.From(JsonValue.Parse(buffer.Bytes, buffer.Count));
        }
    }
}
