// The first page: polls the poses and a picture, and says so when either fails to come.

const POSES_PERIOD_MS = 100;
const STATION_PERIOD_MS = 1000;
const PICTURE_PERIOD_MS = 80;
const RETRY_MS = 1000;
const TIMEOUT_MS = 4000;

const $ = (id) => document.getElementById(id);
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Which bench, where the server has several: ?station=NAME, else the first.
const wished = new URLSearchParams(location.search).get("station");

const shown = { picture: "overlay", reachable: true, station: null, poses: null, problem: null, base: "v1" };
const arrivals = [];

async function ask(path) {
  const answer = await fetch(path, { signal: AbortSignal.timeout(TIMEOUT_MS), cache: "no-store" });
  $("key-form").hidden = answer.status !== 401;
  return { ok: answer.ok, body: await answer.json() };
}

async function repeat(periodMs, action) {
  for (;;) {
    const ok = await action();
    await sleep(ok ? periodMs : Math.max(periodMs, RETRY_MS));
  }
}

async function pollPoses() {
  try {
    const { ok, body } = await ask(`${shown.base}/poses`);
    shown.reachable = true;
    shown.problem = ok ? null : body;
    if (ok) {
      countFrame(body);
      shown.poses = body;
    }
    return ok;
  } catch {
    shown.reachable = false;
    return false;
  } finally {
    render();
  }
}

async function pollStation() {
  try {
    const { ok, body } = await ask("v1/stations");
    if (ok) chooseStation(body.stations);
    return ok;
  } catch {
    return false;
  }
}

function chooseStation(stations) {
  shown.station = stations.find((one) => one.station === wished) ?? stations[0];
  if (stations.length === 1) return;
  shown.base = `v1/stations/${encodeURIComponent(shown.station.station)}`;
  const links = stations.map(({ station }) => {
    const link = document.createElement("a");
    link.href = `?station=${encodeURIComponent(station)}`;
    link.textContent = station;
    return link;
  });
  $("stations").replaceChildren(...links);
}

async function pollPicture() {
  try {
    const answer = await fetch(`${shown.base}/${shown.picture}.jpg`, {
      signal: AbortSignal.timeout(TIMEOUT_MS),
      cache: "no-store",
    });
    if (!answer.ok) return false;
    const address = URL.createObjectURL(await answer.blob());
    const picture = $("picture");
    const before = picture.src;
    picture.src = address;
    await picture.decode();
    if (before.startsWith("blob:")) URL.revokeObjectURL(before);
    return true;
  } catch {
    return false;
  }
}

// Frames a second, from the numbers and exposures of the snapshots of the last two seconds.
function countFrame(poses) {
  const last = arrivals.at(-1);
  if (last && last.boot !== poses.boot_id) arrivals.length = 0;
  if (last?.seq === poses.seq) return;
  arrivals.push({ boot: poses.boot_id, seq: poses.seq, atUs: poses.captured_at_us });
  while (arrivals[0].atUs < poses.captured_at_us - 2e6) arrivals.shift();
}

function frameRate() {
  if (arrivals.length < 2 || shown.poses.stale) return "–";
  const first = arrivals[0];
  const last = arrivals.at(-1);
  return (((last.seq - first.seq) * 1e6) / (last.atUs - first.atUs)).toFixed(0);
}

function render() {
  const { station, poses } = shown;
  renderState();
  if (station) {
    const facts = station.facts;
    $("station").textContent = facts
      ? `${station.station} · ${facts.asset ?? facts.source} · ${facts.method}`
      : station.station;
    const ms = station.worker.frame_ms;
    $("tracking").textContent = ms === null ? "–" : `${ms.toFixed(1)} ms`;
  }
  if (!poses) return;
  $("rate").textContent = frameRate();
  $("age").textContent = age(poses.age_us);
  document.body.dataset.stale = String(poses.stale || !shown.reachable);
  renderParts(poses.parts);
}

function age(us) {
  return us < 1e6 ? `${(us / 1e3).toFixed(0)} ms` : `${(us / 1e6).toFixed(0)} s`;
}

function renderState() {
  const { reachable, station, poses, problem } = shown;
  const worker = station?.worker;
  if (!reachable) {
    setState("unreachable", "The server does not answer. Is it still running?", null);
  } else if (problem) {
    const told = problem.worker ?? { phase: "failed", message: problem.detail, progress: null };
    setState(told.phase, sentence(told.message), told.progress);
  } else if (poses?.stale) {
    const message = worker && worker.phase !== "running" ? `: ${worker.message}` : "";
    setState("stale", `Poses are ${age(poses.age_us)} old${message}. Do not rely on them.`, null);
  } else {
    setState("running", "", null);
  }
}

function sentence(text) {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}…`;
}

function setState(state, message, progress) {
  const pill = $("state");
  pill.dataset.state = state;
  pill.textContent = state === "running" ? "tracking" : state;
  $("banner").hidden = message === "";
  $("banner").dataset.level = state === "unreachable" || state === "failed" ? "bad" : "unsure";
  $("banner-text").textContent = message;
  const bar = $("banner-progress");
  bar.hidden = progress === null;
  bar.value = progress ?? 0;
}

function renderParts(parts) {
  const body = $("parts");
  while (body.rows.length > parts.length) body.deleteRow(-1);
  while (body.rows.length < parts.length) body.append(newRow());
  parts.forEach((part, place) => fillRow(body.rows[place], part));
}

function newRow() {
  const row = document.createElement("tr");
  row.innerHTML =
    '<td></td><td class="status"></td><td><meter min="0" max="1" low="0.4" high="0.7" optimum="1">' +
    '</meter><span></span></td><td class="number"><div></div><div></div></td>';
  return row;
}

function fillRow(row, part) {
  const [name, status, confidence, pose] = row.cells;
  row.dataset.status = part.status;
  name.textContent = part.part;
  status.textContent = part.status;
  confidence.firstChild.value = part.confidence;
  confidence.lastChild.textContent = part.confidence.toFixed(2);
  pose.firstChild.textContent = numbers(part.position, 1000, 1, 7);
  pose.lastChild.textContent = numbers(part.orientation, 1, 3, 7);
}

function numbers(values, factor, digits, width) {
  if (values === null) return "–";
  return values.map((value) => (value * factor).toFixed(digits).padStart(width)).join("");
}

for (const button of document.querySelectorAll("[data-picture]")) {
  button.addEventListener("click", () => {
    shown.picture = button.dataset.picture;
    for (const each of document.querySelectorAll("[data-picture]")) {
      each.setAttribute("aria-pressed", String(each === button));
    }
  });
}

$("curl").textContent = `curl ${location.origin}/v1/poses`;
repeat(POSES_PERIOD_MS, pollPoses);
repeat(STATION_PERIOD_MS, pollStation);
repeat(PICTURE_PERIOD_MS, pollPicture);
