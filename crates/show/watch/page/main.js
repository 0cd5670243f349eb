// The page: a stream of events from the program, and what is shown of it.

import * as charts from "./charts.js";
import { ask, byId, el, fill, readUnits, tell, unitOf } from "./dom.js";
import { offered, operate, progress, recording, refresh } from "./operate.js";
import * as tables from "./tables.js";
import { drawPoles, drawSide } from "./views.js";

/// Without a message for so long the connection is lost, though nobody has said so, ms.
const SILENCE = 20_000;

/// Time between two tries to begin the stream, ms.
const RETRY = 2000;

/// Time between two changes of the texts that move with the samples, and of the side view, ms: a text that changes makes the browser lay out the page.
const TEXT_PERIOD = 190;

let defaults = [];
let sideView = [];
let setpoints = [];
let vehicle;
/// Every namespace that was met, those of vehicles first.
let vehicles = [];
/// Those of them that are drawn.
let shown = [];
let stream;
/// How often it was to be opened, and when that is tried again.
let attempts = 0;
let retry;
/// The channels of the stream, in its order.
let channels = [];
let sections = {};
let heard = 0;
let alive = [];

/// How much is drawn, for those who measure the page.
const stats = { frames: 0, milliseconds: 0, messages: 0 };
window.planesman = { stats };

/// The charts shown of the vehicle: those of the start, or what the user has made of them.
const key = () => `charts:${vehicle}`;
function specifications() {
  try {
    const kept = JSON.parse(localStorage.getItem(key()));
    if (Array.isArray(kept)) return kept;
  } catch {
    // Not ours; the charts of the start are shown.
  }
  if (vehicle === undefined) return [];
  return defaults.map((chart) => inUnits({
    ...chart,
    traces: chart.traces.map((trace) => ({ ...trace, channel: `${vehicle}/${trace.channel}` })),
  }));
}

/// A chart of quantities in SI, drawn in the page's unit.
function inUnits(chart) {
  const { symbol, scale } = unitOf(chart.unit);
  return { ...chart, unit: symbol, traces: chart.traces.map((trace) => ({ ...trace, scale })) };
}

function keep(list) {
  if (list) localStorage.setItem(key(), JSON.stringify(list));
  else localStorage.removeItem(key());
  begin();
}

/// Whether all vehicles are shown beside the one that is operated.
const showsAll = () => byId("all").checked && vehicles.length > 1;

/// The vehicles to draw: of all, those that have a topic of the charts.
function fleet() {
  if (vehicle === undefined) return [];
  if (!showsAll()) return [vehicle];
  const published = new Set((sections.topics ?? []).map((topic) => topic.name));
  const drawn = specifications().map((chart) => chart.traces[0].channel).filter((channel) => channel.startsWith(`${vehicle}/`));
  const has = (channel) => published.has(channel.split(":")[0]) || charts.latest(channel) !== undefined;
  return vehicles.filter((name) => name === vehicle || drawn.some((channel) => has(name + channel.slice(vehicle.length)))).sort();
}

/// A chart with its first line for each of several vehicles.
function ofEach(chart) {
  const [first, ...rest] = chart.traces;
  if (shown.length < 2 || !first.channel.startsWith(`${vehicle}/`)) return chart;
  const traces = shown.map((name) => ({ ...first, label: name || "/", channel: name + first.channel.slice(vehicle.length) }));
  const title = rest.some((trace) => !trace.band) ? `${chart.title}: ${first.label}` : chart.title;
  return { ...chart, title, traces };
}

/// Whether a node or topic belongs to the vehicle that is shown, or to none.
function concerns(name) {
  const within = (place) => name.startsWith(`${place}/`);
  return showsAll() || within(vehicle) || !vehicles.some((other) => other && within(other));
}

/// Shows a vehicle.
function choose(name) {
  if (name !== vehicle && !showsAll()) charts.restart();
  vehicle = name;
  history.replaceState(undefined, "", `#${vehicle}`);
  operate(vehicle, setpoints);
  tables.showOnly(concerns);
  begin();
  update(sections);
  tables.showLog();
  refresh(alive);
}

/// Draws the charts that are shown, and connects them.
function begin() {
  shown = fleet();
  const list = specifications().map(ofEach);
  charts.show(list, (number) => keep(specifications().filter((_, k) => k !== number)), followed);
  for (const chart of document.querySelectorAll(".chart")) {
    const title = chart.querySelector("b").textContent;
    Object.assign(chart, { role: "figure", ariaLabel: title });
    Object.assign(chart.querySelector("canvas"), { role: "img", ariaLabel: `${title} over time; the latest values are above it` });
  }
  const drawn = list.flatMap((chart) => chart.traces.map((trace) => trace.channel));
  const seen = shown.flatMap((name) => sideView.map((channel) => `${name}/${channel}`));
  channels = [...new Set([...drawn, ...seen])];
  connect();
}

/// Has the channels kept and opens their stream, again and again until there is one.
async function connect() {
  clearTimeout(retry);
  stream?.close();
  const attempt = (attempts += 1);
  const fail = (reason) => {
    connected(false, reason);
    retry = setTimeout(connect, RETRY);
  };
  const kept = await ask({ do: "keep", channels });
  if (attempt !== attempts) return;
  if (!kept.ok) return fail(kept.denied ? kept.message : undefined);
  stream = new EventSource(`events?${channels.map((channel) => `channel=${encodeURIComponent(channel)}`).join("&")}`);
  stream.onopen = () => {
    charts.reconnected();
    kept.refused.forEach((reason, k) => { if (reason) charts.refuse(channels[k], reason); });
    tables.clearLog();
    connected(true);
  };
  stream.onmessage = (event) => take(JSON.parse(event.data));
  // Not by the browser's own means: a program that has been started anew keeps other channels.
  stream.onerror = () => {
    stream.close();
    fail();
  };
}

function connected(is, reason = "No connection to planesman watch") {
  heard = performance.now();
  byId("connection").textContent = is ? "connected" : "no connection; trying again";
  byId("connection").className = is ? "good" : "bad";
  const notice = byId("notice");
  notice.hidden = is;
  notice.textContent = `${reason}. The data shown is old. The page updates again when the program runs and its new address has been opened in this browser.`;
}

/// Takes a message of the stream.
function take(message) {
  heard = performance.now();
  stats.messages += 1;
  for (const [index, restarted, times, values] of message.series ?? []) charts.take(channels[index], restarted, times, values);
  for (const [index, reason] of message.refused ?? []) charts.refuse(channels[index], reason);
  if (message.log) tables.takeLog(message.log);
  if (message.sections) {
    Object.assign(sections, message.sections);
    update(message.sections);
  }
  if (message.series) schedule();
}

/// Shows the sections that are new.
function update(news) {
  if (news.vehicles || news.nodes) showVehicles();
  if (news.nodes) {
    const before = alive.join();
    for (const node of news.nodes) if (node.state === "gone") tables.forget(node.name);
    alive = news.nodes.filter((node) => node.state !== "gone").map((node) => node.name);
    tables.showNodes(news.nodes);
    tables.showParameters(news.nodes);
    if (before !== alive.join()) refresh(alive);
    const lost = lostOf(vehicle);
    const notice = byId("notice");
    notice.hidden = !lost.length;
    notice.textContent = lost.map((node) => `${node.name} is ${node.state} for ${node.for ?? 0} s`).join("; ");
  }
  if (news.topics) {
    tables.showTopics(news.topics);
    showTopics(news.topics);
    if (fleet().join() !== shown.join()) begin();
  }
  if (news.services) offered(news.services);
  if (news.diagnostics) {
    tables.showDiagnostics(news.diagnostics);
    recording(news.diagnostics);
  }
  if (news.parameters && tables.parametersChanged(news.parameters).some((node) => node.startsWith(`${vehicle}/`))) refresh(alive);
  progress(sections);
  if (Object.keys(news).some((name) => name.startsWith("model:") || name.startsWith("vehicle:"))) poles();
}

function poles() {
  drawPoles(sections[`model:${vehicle}/model`], sections[`vehicle:${vehicle}`]);
}

/// The nodes of a vehicle that are silent or gone.
const lostOf = (name) => (sections.nodes ?? []).filter((node) => node.state !== "alive" && node.name.startsWith(`${name}/`));

/// Lists the vehicles, also those that have gone; the one named in the address is chosen, or the first.
function showVehicles() {
  const now = sections.vehicles ?? [];
  vehicles = [...now, ...vehicles.filter((name) => !now.includes(name))];
  const select = byId("vehicle");
  const texts = vehicles.map((name) => {
    const lost = lostOf(name).length;
    return (name || "/") + (lost ? ` (${lost} ${lost === 1 ? "node" : "nodes"} lost)` : "");
  });
  if ([...select.options].map((it) => it.textContent).join("\n") !== texts.join("\n")) {
    fill(select, ...vehicles.map((name, k) => el("option", { value: name }, texts[k])));
    select.value = vehicle;
  }
  byId("all").parentElement.hidden = vehicles.length < 2;
  if (vehicle === undefined && vehicles.length) {
    const named = location.hash.slice(1);
    choose(vehicles.includes(named) ? named : vehicles[0]);
    select.value = vehicle;
  }
}

/// Lists the topics from which a chart can be added.
function showTopics(topics) {
  const select = byId("topic");
  const names = topics.map((topic) => topic.name);
  if ([...select.options].map((it) => it.value).join("\n") === names.join("\n")) return;
  const chosen = select.value;
  fill(select, ...names.map((name) => el("option", { value: name }, name)));
  if (names.includes(chosen)) select.value = chosen;
  showFields();
}

async function showFields() {
  const topic = byId("topic").value;
  const output = byId("add").querySelector("output");
  if (!topic) return;
  const answer = await ask({ do: "fields", topic });
  if (topic !== byId("topic").value) return;
  fill(byId("field"), ...(answer.fields ?? []).map(([field, si]) => {
    const option = el("option", { value: field }, field + (si ? ` [${unitOf(si).symbol}]` : ""));
    option.dataset.si = si;
    return option;
  }));
  tell(output, answer.ok ? { ok: true, message: answer.fields.length ? " " : "the topic has no numeric field" } : answer);
}

// Drawing: once for all that has come since the last picture.

let scheduled = false;
function schedule() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    const began = performance.now();
    if (charts.draw()) stats.frames += 1;
    if (began - lastText >= TEXT_PERIOD) {
      lastText = began;
      charts.nameAll();
      drawSide(vehicle, sections[`vehicle:${vehicle}`], shown);
    }
    stats.milliseconds += performance.now() - began;
  });
}
let lastText = 0;

function followed(follow) {
  const pause = byId("pause");
  pause.textContent = follow ? "Pause" : "Follow";
  pause.className = follow ? "" : "on";
  if (follow) byId("scroll").value = 1000;
}

setInterval(() => {
  charts.nameAll();
  const end = charts.seenEnd();
  byId("clock").textContent = end === undefined ? "" : `charts at ${end.toFixed(1)} s`;
  if (stream && performance.now() - heard > SILENCE) {
    connected(false);
    connect();
  }
}, 1000);

window.addEventListener("redraw", schedule);
byId("vehicle").addEventListener("change", (event) => choose(event.target.value));
byId("all").addEventListener("change", () => {
  charts.restart();
  choose(vehicle);
});
byId("pause").addEventListener("click", charts.toggle);
byId("span").addEventListener("change", (event) => charts.setSpan(Number(event.target.value)));
byId("scroll").addEventListener("input", (event) => charts.scroll(event.target.value / 1000));
byId("png").addEventListener("click", charts.savePicture);
byId("csv").addEventListener("click", charts.saveTable);
byId("topic").addEventListener("change", showFields);
byId("defaults").addEventListener("click", () => keep(undefined));
byId("add").addEventListener("submit", (event) => {
  event.preventDefault();
  const [topic, field] = [byId("topic").value, byId("field").value];
  if (!field) return;
  const trace = { label: field, channel: `${topic}:${field}`, held: false, band: false };
  const unit = byId("field").selectedOptions[0].dataset.si;
  keep([...specifications(), inUnits({ title: `${topic} ${field}`, unit, down: false, traces: [trace] })]);
});
byId("log_level").addEventListener("change", tables.showLog);
byId("log_filter").addEventListener("input", tables.showLog);
byId("parameter_filter").addEventListener("input", tables.filterParameters);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => choose(vehicle));

/// The charts of the start come from the program; then its stream is opened.
async function start() {
  try {
    const asked = ["charts", "side_view", "setpoints"].map(async (name) => (await fetch(name)).json());
    [defaults, sideView, setpoints] = await Promise.all([...asked, readUnits()]);
  } catch {
    connected(false);
    setTimeout(start, 1000);
    return;
  }
  operate("", setpoints);
  begin();
}
// The token of the first visit is in a cookie now, and need not stand in the address.
if (location.search) location.replace(`/${location.hash}`);
else start();
