// The page: puts the station's news into the document, ten times a second at most.

import { Api } from "./api";
import { BannerView } from "./banner_view";
import { banners } from "./banners";
import { ServerClock } from "./clock";
import { synchronise } from "./clock_sync";
import { controls } from "./controls";
import { byId, duration, element, setText } from "./dom";
import { FrameRate } from "./frame_rate";
import { PoseBuffer } from "./interpolation";
import { keyForm } from "./key_form";
import { PartsView } from "./parts_view";
import { PictureStream } from "./picture";
import { Playout } from "./playout";
import { loadShapes, type Shapes } from "./shapes";
import { Stage } from "./stage";
import { type Reach, StationWatch } from "./station_watch";
import { StepCard } from "./step_card";
import { SnapshotStream } from "./stream";
import type { AssetInfo, PoseSnapshot, StationInfo } from "./types";
import { offerAr } from "./xr/offer";

const RENDER_MS = 100;
const RETRY_ASSET_MS = 2000;

/** Everything that one station's page consists of. */
export class Page {
  private readonly clock = new ServerClock();
  private readonly buffer = new PoseBuffer();
  private readonly playout = new Playout();
  private readonly rate = new FrameRate();
  private readonly stage = new Stage(this.clock, this.buffer, this.playout);
  private readonly bannerView = new BannerView(byId("banners"));
  private readonly partsView = new PartsView();
  private readonly watch: StationWatch;
  private api: Api | null = null;
  private card: StepCard | null = null;
  private station: StationInfo | null = null;
  private asset: AssetInfo | null = null;
  private shapes: Shapes | null = null;
  private wanted = "";
  private pictures: PictureStream | null = null;
  private stream: SnapshotStream | null = null;

  /** @param wished the station to show; null for the first. */
  constructor(
    private readonly base: URL,
    private readonly wished: string | null,
  ) {
    this.watch = new StationWatch(base, (reach) => this.onReach(reach));
    keyForm(base, () => this.watch.ask());
    controls(this.stage, () => this.choosePictures());
    document.addEventListener("visibilitychange", () => this.choosePictures());
    setInterval(() => this.render(), RENDER_MS);
  }

  private onReach(reach: Reach): void {
    byId("key-form").hidden = !reach.needsKey;
    const station = reach.stations.find((one) => one.station === this.wished) ?? reach.stations[0];
    if (station === undefined) return;
    this.station = station;
    if (this.api === null) this.open(station, reach.stations);
    const camera = station.facts?.cameras.find((each) => each.name === "color");
    if (camera) this.stage.setCamera(camera);
    const asset = station.facts?.asset ?? null;
    if (asset !== null && `${asset} ${station.worker.boot_id}` !== this.wanted) {
      this.wanted = `${asset} ${station.worker.boot_id}`;
      void this.loadAsset(asset, this.wanted);
    }
  }

  /** The first answer: from here on the station's name is known. */
  private open(station: StationInfo, all: StationInfo[]): void {
    const api = new Api(this.base, station.station);
    this.api = api;
    this.card = new StepCard(api, announce);
    this.stream = new SnapshotStream(api, "camera", (snapshot) => this.onSnapshot(snapshot));
    this.choosePictures();
    void synchronise(api, this.clock, new AbortController().signal);
    showStations(all, station.station);
    void offerAr(() =>
      this.asset && this.shapes && this.card
        ? { api, asset: this.asset, shapes: this.shapes, clock: this.clock, card: this.card }
        : null,
    );
  }

  private async loadAsset(name: string, wanted: string): Promise<void> {
    try {
      const asset = (await this.api?.asset(name)) ?? null;
      if (asset === null || wanted !== this.wanted) return;
      const isKnown = JSON.stringify(asset.parts) === JSON.stringify(this.asset?.parts);
      this.asset = asset;
      if (isKnown || this.api === null) return;
      this.shapes = await loadShapes(this.api, asset);
      if (wanted === this.wanted) this.stage.setShapes(this.shapes);
    } catch {
      // Asked for again with the next news of the station.
      setTimeout(() => {
        if (wanted === this.wanted) this.wanted = "";
      }, RETRY_ASSET_MS);
    }
  }

  private onSnapshot(snapshot: PoseSnapshot): void {
    const periodUs = snapshot.captured_at_us - (this.buffer.latest?.captured_at_us ?? 0);
    const isNew = this.rate.count(snapshot);
    this.buffer.push(snapshot);
    if (isNew && !snapshot.stale && periodUs > 0 && periodUs < 1e6) {
      this.playout.arrived(this.clock.nowUs() - snapshot.captured_at_us, periodUs);
    }
  }

  /** The picture that is needed now, if any: none in the background, nor where none is shown. */
  private choosePictures(): void {
    this.pictures?.close();
    this.pictures = null;
    if (this.api === null || document.hidden || this.stage.view === "parts") return;
    const kind = this.stage.hasOverlay || this.stage.view === "camera" ? "frame" : "overlay";
    this.pictures = new PictureStream(this.api, kind, (picture) => this.stage.take(picture));
  }

  private render(): void {
    const { reach } = this.watch;
    const snapshot = this.buffer.latest;
    const ageUs = snapshot === null ? 0 : this.clock.nowUs() - snapshot.captured_at_us;
    const backForMs = reach.backAtMs === null ? null : performance.now() - reach.backAtMs;
    const { reachable, problem } = reach;
    const isOther = this.wished !== null && this.station?.station !== this.wished;
    const unknownStation = isOther ? this.wished : null;
    this.bannerView.show(
      reach.needsKey
        ? []
        : banners({
            reachable,
            backForMs,
            problem,
            unknownStation,
            station: this.station,
            snapshot,
          }),
    );
    this.renderFigures(reach, snapshot, ageUs);
    if (snapshot === null) return;
    this.partsView.show(snapshot.parts, this.asset);
    this.card?.show(this.asset, snapshot.assembly);
    this.stage.setStep(this.card?.standing?.current ?? null);
  }

  private renderFigures(reach: Reach, snapshot: PoseSnapshot | null, ageUs: number): void {
    const isOld = !reach.reachable || (snapshot?.stale ?? true);
    const state = stateOf(reach, this.station, snapshot);
    const pill = byId("state");
    pill.dataset.state = state;
    setText(pill, state === "running" ? "live" : state);
    document.body.dataset.stale = String(snapshot !== null && isOld);
    const facts = this.station?.facts;
    setText(byId("station"), stationLine(this.station, this.asset));
    setText(byId("method"), facts?.method ?? "–");
    setText(byId("transport"), this.stream?.transport ?? "–");
    setText(byId("rate"), isOld ? "–" : this.rate.text());
    const ms = this.station?.worker.frame_ms ?? null;
    setText(byId("tracking"), ms === null ? "–" : `${ms.toFixed(1)} ms`);
    setText(byId("age"), snapshot === null ? "–" : duration(ageUs));
    const offset = this.clock.uncertaintyUs;
    setText(byId("clock"), offset === null ? "–" : `± ${(offset / 1000).toFixed(1)} ms`);
  }
}

function stateOf(reach: Reach, station: StationInfo | null, snapshot: PoseSnapshot | null): string {
  if (reach.needsKey) return "locked";
  if (!reach.reachable) return "unreachable";
  if (snapshot === null) return station?.worker.phase ?? "connecting";
  return snapshot.stale ? "stale" : "running";
}

function stationLine(station: StationInfo | null, asset: AssetInfo | null): string {
  if (station === null) return "";
  return `${station.station} · ${asset?.title ?? station.facts?.source ?? "…"}`;
}

function showStations(stations: StationInfo[], current: string): void {
  const links = stations.map(({ station }) => {
    const link = element("a", "", station);
    link.href = `?station=${encodeURIComponent(station)}`;
    if (station === current) link.setAttribute("aria-current", "page");
    return element("li", "", link);
  });
  byId("stations").hidden = stations.length < 2;
  byId("station-list").replaceChildren(...links);
}

/** Tell it to those who do not see it. */
function announce(text: string): void {
  setText(byId("announcer"), text);
}
