// Strip charts over one common time axis: drawn as samples come, paused, zoomed, scrolled, saved.

/* global uPlot */
import { byId, colour, el, save, shown } from "./dom.js";

/// The samples of each channel, as far back as the page has them.
const store = new Map();

/// What is seen of the time axis: the window's length, s (0: all), and where it ends; at the newest sample while it follows.
const view = { follow: true, span: 60, from: 0, to: 1 };

let charts = [];

/// The first sample whose stamp is the machine's time, not a simulation's: the axis begins there.
let origin;
const onAxis = (time) => time > 1e6 ? time - (origin ??= time) : time;
let onChange = () => {};

const COLOURS = ["--c1", "--c2", "--c3", "--c4", "--c5", "--c6", "--c7", "--c8"];

/// The colour of that number, as the style sheet has it.
export const ink = (number) => colour(COLOURS[number % COLOURS.length]);
const HEIGHT = 118;
const LINE = 1.25;

/// As on a strip recorder the pen moves over standing paper: new samples are drawn into the picture that is there, and the whole is drawn again when
/// the axis moves on, by this share of the window at once.
const ADVANCE = 1 / 40;

export function samples(channel) {
  if (!store.has(channel)) store.set(channel, { times: [], values: [], fresh: false });
  return store.get(channel);
}

/// The latest value of a channel.
export const latest = (channel) => samples(channel).values.at(-1);

/// The next samples of every channel are those of a new connection, from the first one that is kept.
export function reconnected() {
  for (const kept of store.values()) kept.fresh = true;
}

/// Takes samples of a channel.
export function take(channel, restarted, times, values) {
  const kept = samples(channel);
  let rebuilt = restarted;
  if (restarted) {
    kept.times.length = kept.values.length = 0;
  } else if (kept.fresh && times.length) {
    // What was there before the connection was lost stays, as far as the program does not send it again.
    let end = kept.times.length;
    while (end > 0 && kept.times[end - 1] >= times[0]) end -= 1;
    kept.times.length = kept.values.length = end;
    rebuilt = true;
  }
  kept.fresh = false;
  for (let k = 0; k < times.length; k += 1) {
    kept.times.push(times[k]);
    kept.values.push(values[k]);
  }
  for (const chart of charts) {
    const index = chart.traces.findIndex((trace) => trace.channel === channel);
    if (index < 0) continue;
    if (rebuilt || times.length > 1000) chart.stale = true;
    else append(chart, index, times, values);
    chart.dirty = chart.unnamed = true;
  }
}

/// Puts samples of a trace into the common rows of its chart; nearly always behind the last one.
function append(chart, index, times, values) {
  const [xs, ...ys] = chart.data;
  const scale = chart.traces[index].scale;
  for (let k = 0; k < times.length; k += 1) {
    const time = onAxis(times[k]);
    let row = xs.length;
    while (row > 0 && xs[row - 1] > time) row -= 1;
    // Behind the pen: the picture is drawn anew.
    if (row <= chart.pens[index]) chart.whole = true;
    if (row > 0 && xs[row - 1] === time) {
      ys[index][row - 1] = values[k] * scale;
      continue;
    }
    if (row === xs.length) {
      xs.push(time);
      ys.forEach((column, at) => column.push(at === index ? values[k] * scale : null));
    } else {
      chart.pens = chart.pens.map((pen) => pen < row ? pen : pen + 1);
      xs.splice(row, 0, time);
      ys.forEach((column, at) => column.splice(row, 0, at === index ? values[k] * scale : null));
    }
  }
}

/// Common rows of several traces: every time once, in order, with each trace's value or null.
function joined(traces) {
  const kept = traces.map((trace) => samples(trace.channel));
  const times = [...new Set(kept.flatMap((one) => one.times))].sort((a, b) => a - b);
  const columns = kept.map((one, index) => {
    let at = 0;
    return times.map((time) => {
      while (at < one.times.length && one.times[at] < time) at += 1;
      return one.times[at] === time ? one.values[at] * (traces[index].scale ?? 1) : null;
    });
  });
  return [times, ...columns];
}

/// The rows of a chart, on the axis that is drawn.
function rows(traces) {
  const [times, ...columns] = joined(traces);
  return [times.map(onAxis), ...columns];
}

/// Begins with another vehicle, whose time is another.
export function restart() {
  origin = undefined;
  view.follow = true;
}

/// Shows these charts; `remove` is called with the number of a chart whose cross is clicked.
export function show(specifications, remove, changed) {
  onChange = changed;
  for (const chart of charts) chart.plot.destroy();
  byId("charts").replaceChildren();
  charts = specifications.map((specification, number) => made(specification, () => remove(number)));
}

function made(specification, remove) {
  const traces = specification.traces;
  const keys = traces.map((trace, k) => {
    const key = el("span", { className: "key" });
    key.style.color = `var(${COLOURS[k % COLOURS.length]})`;
    return key;
  });
  const cross = el("button", { type: "button", title: "Remove this chart", ariaLabel: `Remove ${specification.title}`, onclick: remove }, "×");
  const refusal = el("span", { className: "bad" });
  const unit = specification.unit ? ` [${specification.unit}]` : "";
  const place = el("div", { className: "chart" }, el("div", { className: "head" },
    el("b", {}, specification.title + unit), ...keys.filter((_, k) => !traces[k].band), refusal, cross));
  byId("charts").append(place);
  const chart = { ...specification, place, keys, refusal, data: rows(traces), pens: [], whole: true, dirty: true, unnamed: true, stale: false, seen: true, refused: new Map() };
  const axis = { stroke: colour("--weak"), grid: { stroke: colour("--line"), width: 1 }, ticks: { show: false }, font: "11px system-ui", gap: 3 };
  chart.inks = traces.map((trace, k) => ink(k));
  chart.shade = `${chart.inks[0]}33`;
  chart.band = traces.flatMap((trace, k) => trace.band ? [k] : []);
  chart.plot = new uPlot({
    width: Math.max(200, place.clientWidth),
    height: HEIGHT,
    legend: { show: false },
    padding: [4, 6, 0, 0],
    cursor: { y: false, sync: { key: "time" }, drag: { x: true, y: false, setScale: false }, points: { show: false }, bind: { dblclick: () => () => follow() } },
    scales: { x: { time: false, range: (plot, least, most) => [least, most] }, y: { dir: specification.down ? -1 : 1, range: padded } },
    axes: [
      { ...axis, size: 20, values: (plot, ticks) => ticks.map(clock) },
      { ...axis, size: 52, space: 24 },
    ],
    series: [{}, ...traces.map((trace, k) => ({
      stroke: trace.band ? undefined : chart.inks[k],
      width: LINE,
      spanGaps: true,
      points: { show: false },
      paths: trace.held || trace.band ? uPlot.paths.stepped({ align: 1 }) : undefined,
    }))],
    bands: chart.band.length === 2 ? [{ series: chart.band.map((k) => k + 1), fill: chart.shade }] : [],
    hooks: { setSelect: [selected], setCursor: [(plot) => { chart.cursor = plot.cursor.idx; name(chart); }] },
  }, chart.data, place);
  new ResizeObserver(() => {
    const width = Math.max(200, place.clientWidth);
    if (width === chart.plot.width) return;
    chart.plot.setSize({ width, height: HEIGHT });
    chart.whole = true;
    window.dispatchEvent(new Event("redraw"));
  }).observe(place);
  new IntersectionObserver((entries) => {
    chart.seen = entries.at(-1).isIntersecting;
    window.dispatchEvent(new Event("redraw"));
  }).observe(place);
  return chart;
}

/// The range of values with some room, and never none.
function padded(plot, least, most) {
  if (least === null || least === undefined) return [0, 1];
  const room = most > least ? (most - least) * 0.08 : Math.abs(most) * 0.02 || 1;
  return [least - room, most + room];
}

/// Seconds as the axis has them.
function clock(seconds) {
  const whole = Math.round(seconds * 100) / 100;
  if (Math.abs(whole) < 600) return String(whole);
  const sign = whole < 0 ? "-" : "";
  const rest = Math.abs(whole);
  const two = (number) => String(Math.floor(number)).padStart(2, "0");
  return `${sign}${Math.floor(rest / 60)}:${two(rest % 60)}`;
}

/// The values in the heading: the latest ones, or those under the cursor.
function name(chart) {
  chart.unnamed = false;
  chart.traces.forEach((trace, k) => {
    let row = chart.cursor ?? chart.data[0].length - 1;
    while (row > 0 && chart.data[k + 1][row] === null) row -= 1;
    const text = `${trace.label} ${shown(chart.data[k + 1][row])}`;
    if (chart.keys[k].textContent !== text) chart.keys[k].textContent = text;
  });
}

/// Writes the values that are new into the headings.
export function nameAll() {
  for (const chart of charts) if (chart.seen && chart.unnamed) name(chart);
}

/// Why a channel has no samples, in its chart.
export function refuse(channel, reason) {
  for (const chart of charts) {
    if (!chart.traces.some((trace) => trace.channel === channel)) continue;
    if (reason) chart.refused.set(channel, reason);
    else chart.refused.delete(channel);
    chart.refusal.textContent = [...chart.refused.values()].join("; ");
  }
}

function selected(plot) {
  const { left, width } = plot.select;
  if (width < 4) return;
  const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
  plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  // The other charts are told too; one that was never drawn has no axis yet.
  if (!Number.isFinite(from + to)) return;
  Object.assign(view, { from, to, follow: false });
  redraw();
}

function redraw() {
  onChange(view.follow);
  window.dispatchEvent(new Event("redraw"));
}

/// Goes on with the newest samples at the right edge.
export function follow() {
  view.follow = true;
  redraw();
}

/// Stands still, or goes on.
export function toggle() {
  if (view.follow) {
    view.follow = false;
    redraw();
  } else {
    follow();
  }
}

export function setSpan(seconds) {
  view.span = seconds;
  follow();
}

/// The first and the last time of what is shown.
function extent() {
  let [least, most] = [Infinity, -Infinity];
  for (const chart of charts) {
    const times = chart.data[0];
    if (times.length) [least, most] = [Math.min(least, times[0]), Math.max(most, times.at(-1))];
  }
  return least <= most ? [least, most] : [0, 1];
}

/// Scrolls to that share of the flight, 0 to 1.
export function scroll(share) {
  const [least, most] = extent();
  const width = view.span && view.follow ? view.span : view.to - view.from;
  view.follow = share >= 1;
  view.to = Math.min(most, least + width + share * Math.max(0, most - least - width));
  view.from = view.to - width;
  redraw();
}

/// The end of what is seen on the vehicle's time axis, or nothing before the first sample.
export function seenEnd() {
  const end = view.follow ? extent()[1] : view.to;
  return charts.some((chart) => chart.data[0].length) ? end : undefined;
}

/// How much time is seen, s.
export const seenWidth = () => view.to - view.from;

/// Moves the window over the newest sample, in steps; a flight that is shorter than the window fills it from the left.
function advance(least, most) {
  const step = ADVANCE * (view.span || 2 ** Math.ceil(Math.log2(Math.max(most - least, 1))));
  const end = least + Math.ceil((most - least) / step) * step;
  view.to = view.span ? Math.max(end, least + view.span) : end;
  view.from = view.span ? view.to - view.span : least;
}

/// Draws what has changed; returns how many charts that were.
export function draw() {
  for (const chart of charts) {
    if (!chart.stale) continue;
    chart.data = rows(chart.traces);
    chart.stale = false;
    chart.whole = true;
  }
  if (view.follow) advance(...extent());
  let drawn = 0;
  for (const chart of charts) {
    const stands = !chart.whole && chart.from === view.from && chart.to === view.to;
    if (!chart.seen || (stands && !chart.dirty)) continue;
    if (!stands || !extend(chart)) drawWhole(chart);
    chart.dirty = false;
    drawn += 1;
  }
  return drawn;
}

function drawWhole(chart) {
  const { plot, data: [, ...columns] } = chart;
  plot.batch(() => {
    plot.setData(chart.data, false);
    plot.setScale("x", { min: view.from, max: Math.max(view.to, view.from + 1e-3) });
  });
  Object.assign(chart, { from: view.from, to: view.to, whole: false, drawn: performance.now() });
  chart.pens = columns.map((column) => column.findLastIndex((value) => value !== null));
}

/// Draws the samples behind each trace's pen into the picture that stands; whether that could be done.
function extend(chart) {
  const { plot, pens, traces, data: [times, ...columns] } = chart;
  // The values under the cursor are those of the last whole picture.
  if (chart.cursor !== undefined && chart.cursor !== null && performance.now() - chart.drawn > 250) return false;
  const news = columns.map((column, k) => {
    const found = [];
    for (let row = pens[k] + 1; row < times.length && times[row] <= view.to; row += 1) if (column[row] !== null) found.push(row);
    return found;
  });
  const { min, max } = plot.scales.y;
  if (news.some((found, k) => found.some((row) => !(columns[k][row] >= min && columns[k][row] <= max)))) return false;
  const { ctx: context, bbox } = plot;
  const x = (row) => Math.round(plot.valToPos(times[row], "x", true));
  const y = (k, row) => Math.round(plot.valToPos(columns[k][row], "y", true));
  const first = news.map((found, k) => pens[k] < 0 ? found[0] : pens[k]);
  context.save();
  context.beginPath();
  context.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  context.clip();
  context.lineWidth = LINE * uPlot.pxRatio;
  context.lineJoin = "round";
  const [low, high] = chart.band;
  if (high !== undefined) {
    context.fillStyle = chart.shade;
    let last = first[low];
    for (const row of news[low].filter((row) => columns[high][row] !== null)) {
      context.fillRect(x(last), y(low, last), x(row) - x(last), y(high, last) - y(low, last));
      last = row;
    }
  }
  news.forEach((found, k) => {
    if (!found.length || traces[k].band) return;
    context.strokeStyle = chart.inks[k];
    context.beginPath();
    let last = first[k];
    context.moveTo(x(last), y(k, last));
    for (const row of found) {
      if (traces[k].held) context.lineTo(x(row), y(k, last));
      context.lineTo(x(row), y(k, row));
      last = row;
    }
    context.stroke();
  });
  context.restore();
  news.forEach((found, k) => { pens[k] = found.at(-1) ?? pens[k]; });
  return true;
}

/// Saves the charts as they are seen.
export function savePicture() {
  if (!charts.length) return;
  const canvases = charts.map((chart) => chart.place.querySelector("canvas"));
  const ratio = window.devicePixelRatio || 1;
  const title = 18 * ratio;
  const picture = el("canvas", {
    width: Math.max(...canvases.map((it) => it.width)),
    height: canvases.reduce((sum, it) => sum + it.height + title, 0),
  });
  const context = picture.getContext("2d");
  context.fillStyle = colour("--card");
  context.fillRect(0, 0, picture.width, picture.height);
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  context.textBaseline = "middle";
  let top = 0;
  charts.forEach((chart, number) => {
    let left = 6 * ratio;
    const write = (text, ink) => {
      context.fillStyle = colour(ink);
      context.fillText(text, left, top + title / 2);
      left += context.measureText(text).width + 12 * ratio;
    };
    write(chart.title + (chart.unit ? ` [${chart.unit}]` : ""), "--text");
    chart.traces.forEach((trace, k) => trace.band || write(trace.label, COLOURS[k % COLOURS.length]));
    context.drawImage(canvases[number], 0, top + title);
    top += canvases[number].height + title;
  });
  picture.toBlob((blob) => save("planesman.png", blob));
}

/// Saves all samples of the charts' channels as a table, in SI units.
export function saveTable() {
  const channels = [...new Set(charts.flatMap((chart) => chart.traces.map((trace) => trace.channel)))];
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
  const [times, ...columns] = joined(channels.map((channel) => ({ channel, scale: 1 })));
  const lines = [["time", ...channels].map(quoted).join(",")];
  times.forEach((time, row) => lines.push([time, ...columns.map((column) => column[row] ?? "")].join(",")));
  save("planesman.csv", new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
}
