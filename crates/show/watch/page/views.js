// The vehicle from the side and from above, and the poles of its identified model beside the true ones.

import { ink, latest, samples } from "./charts.js";
import { byId, colour, fitted, shown } from "./dom.js";

const DEGREES = 180 / Math.PI;
const MODES = ["off", "pitch", "depth", "open_loop", "hover"];

/// Draws the vehicle at its depth and pitch, its planes, its ram, and where it came from, with the others in view.
export function drawSide(place, vehicle, places) {
  const of = (channel) => latest(`${place}/${channel}`);
  const depth = of("state:depth");
  const { context: c, width, height } = fitted(byId("side_view"));
  if (depth === undefined) {
    c.fillStyle = colour("--weak");
    c.font = "12px system-ui";
    c.fillText("no state received from this vehicle", 10, 20);
    byId("attitude").textContent = "";
    return;
  }
  const pitch = of("state:pitch") ?? 0;
  const planes = of("state:dive_planes") ?? 0;
  const bottom = vehicle?.bottom > 0 ? vehicle.bottom : undefined;

  // Metres to pixels, the same both ways: the trace behind the vehicle fills the view.
  const traces = new Map(places.map((name) => [name, past(name)]));
  const points = [...traces.values()].flat();
  const deepest = points.reduce((most, point) => Math.max(most, point[1]), Math.max(bottom ?? 0, depth, 1)) * 1.15;
  const top = 20;
  const floor = height - 44;
  const down = (floor - top) / deepest;
  const bow = width * 0.62;
  const here = of("state:distance") ?? 0;
  const foremost = points.reduce((most, point) => Math.max(most, point[0]), here);
  const behind = Math.max(foremost - points.reduce((least, point) => Math.min(least, point[0]), here), 1);
  const x = (distance) => bow - (foremost - distance) * along;
  const along = (bow - 20) / behind;
  const y = (metres) => top + metres * down;

  c.fillStyle = colour("--water");
  c.fillRect(0, y(0), width, floor - y(0));
  c.strokeStyle = colour("--accent");
  c.lineWidth = 1;
  c.beginPath();
  for (let at = 0; at <= width; at += 4) c.lineTo(at, y(0) + 1.5 * Math.sin((at + foremost * 20) / 9));
  c.stroke();
  if (bottom !== undefined) {
    c.fillStyle = colour("--ground");
    c.fillRect(0, y(bottom), width, floor - y(bottom));
  }
  c.fillStyle = colour("--weak");
  c.font = "11px system-ui";
  c.fillText("surface", 4, y(0) - 5);
  for (const metres of marks(deepest)) c.fillText(`${metres} m`, width - 38, y(metres) + 4);

  for (const [name, trace] of traces) {
    c.strokeStyle = ink(places.indexOf(name));
    c.beginPath();
    for (const [distance, at] of trace) c.lineTo(x(distance), y(at));
    c.stroke();
  }
  const setpoint = of("control_state:depth_setpoint");
  if (setpoint !== undefined) {
    c.strokeStyle = colour("--c2");
    c.setLineDash([4, 4]);
    c.beginPath();
    c.moveTo(0, y(setpoint));
    c.lineTo(width, y(setpoint));
    c.stroke();
    c.setLineDash([]);
  }

  // The one that is operated over the others.
  for (const name of [...places.filter((other) => other !== place), place]) {
    const its = (channel, other = 0) => latest(`${name}/${channel}`) ?? other;
    const [left, top] = [x(its("state:distance", here)), y(its("state:depth"))];
    c.save();
    c.translate(left, top);
    c.rotate(-its("state:pitch"));
    hull(c, its("state:dive_planes"), places.length > 1 ? ink(places.indexOf(name)) : colour("--text"));
    c.restore();
    c.fillStyle = ink(places.indexOf(name));
    if (places.length > 1) c.fillText(name || "/", left - 40 + 30 * places.indexOf(name), top - 16);
  }
  ram(c, height, of("dha_state:ram"), extreme(`${place}/dha_state:ram`));
  above(c, width, places);

  const mode = MODES[of("control_state:mode")] ?? "–";
  const pulses = of("dha_state:pulses");
  byId("attitude").textContent =
    `depth ${shown(depth)} m, pitch ${(pitch * DEGREES).toFixed(1)}°, planes ${(planes * DEGREES).toFixed(1)}°, mode ${mode}` +
    (pulses === undefined ? "" : `, ${pulses} pulses`);
}

/// From above, in the corner, once a vehicle has left its vertical plane: the initial heading is up.
function above(c, width, places) {
  const tracks = places.map((name) => past(name, "state:cross_track"));
  const all = tracks.flat();
  if (!all.some(([, aside]) => Math.abs(aside) > 1e-6)) return;
  const [side, left, top] = [120, width - 168, 8];
  const [low, high] = [0, 1].map((i) => all.map((it) => it[i])).reduce(
    ([least, most], values) => [[...least, Math.min(...values)], [...most, Math.max(...values)]], [[], []]);
  const unit = (side - 24) / Math.max(high[0] - low[0], high[1] - low[1], 1);
  const at = ([along, aside]) => [left + 12 + (aside - low[1]) * unit, top + side - 12 - (along - low[0]) * unit];
  c.fillStyle = colour("--card");
  c.strokeStyle = colour("--line");
  c.fillRect(left, top, side, side);
  c.strokeRect(left, top, side, side);
  places.forEach((name, k) => {
    c.strokeStyle = c.fillStyle = ink(k);
    c.beginPath();
    tracks[k].forEach((point) => c.lineTo(...at(point)));
    c.stroke();
    if (!tracks[k].length) return;
    c.save();
    c.translate(...at(tracks[k].at(-1)));
    c.rotate(latest(`${name}/state:yaw`) ?? 0);
    c.beginPath();
    c.moveTo(0, -7);
    c.lineTo(4, 5);
    c.lineTo(-4, 5);
    c.fill();
    c.restore();
  });
  c.fillStyle = colour("--weak");
  c.fillText(`from above, ${shown(side / unit)} m`, left + 4, top + 12);
}

/// Where the vehicle came from: distance and another of its numbers, at most some hundred points of the last ten minutes.
function past(place, other = "state:depth") {
  const distance = samples(`${place}/state:distance`);
  const depth = samples(`${place}/${other}`);
  const count = Math.min(distance.values.length, depth.values.length);
  const first = Math.max(0, count - 12_000);
  const step = Math.max(1, Math.ceil((count - first) / 300));
  const points = [];
  for (let k = first; k < count; k += step) points.push([distance.values[k], depth.values[k]]);
  if (count) points.push([distance.values[count - 1], depth.values[count - 1]]);
  return points;
}

/// Round depths for the scale.
function marks(deepest) {
  const rough = deepest / 4;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((it) => it >= rough);
  const count = Math.floor(deepest / step);
  return Array.from({ length: count }, (_, k) => Number(((k + 1) * step).toPrecision(3)));
}

/// Bow to the right, about the origin; planes positive to dive: the bow's leading edge down, the stern's up.
function hull(c, planes, outline) {
  c.fillStyle = colour("--card");
  c.strokeStyle = outline;
  c.lineWidth = 1.5;
  c.beginPath();
  c.moveTo(-44, -4);
  c.lineTo(-26, -10);
  c.lineTo(30, -10);
  c.quadraticCurveTo(50, -8, 50, 0);
  c.quadraticCurveTo(50, 8, 30, 10);
  c.lineTo(-26, 10);
  c.lineTo(-44, 4);
  c.closePath();
  c.fill();
  c.stroke();
  c.strokeStyle = c.fillStyle = colour("--c2");
  for (const [at, sign] of [[26, 1], [-34, -1]]) {
    c.save();
    c.translate(at, 0);
    c.rotate(sign * planes);
    c.fillRect(-11, -1.75, 22, 3.5);
    c.restore();
  }
}

/// The largest travel of the ram so far: its scale.
let travel = { channel: "", seen: 0, most: 0 };
function extreme(channel) {
  const { values } = samples(channel);
  if (travel.channel !== channel || travel.seen > values.length) travel = { channel, seen: 0, most: 0 };
  for (; travel.seen < values.length; travel.seen += 1) travel.most = Math.max(travel.most, Math.abs(values[travel.seen]));
  return travel.most;
}

/// The cylinder with its piston.
function ram(c, height, position, most) {
  if (position === undefined) return;
  const [left, top, length, bore] = [1, height - 26, 140, 20];
  c.fillStyle = colour("--card");
  c.strokeStyle = colour("--text");
  c.lineWidth = 1;
  c.fillRect(left, top, length, bore);
  c.strokeRect(left, top, length, bore);
  const middle = left + length / 2 + (most > 0 ? position / most : 0) * (length / 2 - 8);
  c.fillStyle = colour("--c2");
  c.fillRect(middle - 3, top + 1, 6, bore - 2);
  c.fillRect(middle, top + bore / 2 - 1.5, left + length + 14 - middle, 3);
  c.fillStyle = colour("--weak");
  c.fillText(`ram ${(position * 1000).toFixed(2)} mm`, left + length + 24, top + 14);
}

/// Draws the poles of the chosen pair of signals in the s plane, two standard deviations about each, and the true ones.
export function drawPoles(models, vehicle) {
  const { context: c, width, height } = fitted(byId("poles"));
  const model = Object.values(models ?? {})[0];
  const found = model?.poles ?? [];
  const truth = vehicle?.poles ?? [];
  const all = [...found, ...truth].filter((pole) => Number.isFinite(pole.re) && Number.isFinite(pole.im));
  c.font = "11px system-ui";
  if (!all.length) {
    c.fillStyle = colour("--weak");
    c.fillText("no model has been published", 10, 20);
    byId("pole_text").textContent = vehicle?.reason ?? "";
    return;
  }
  // The true poles and their surroundings; a pole far off is drawn at the edge.
  const modes = all.filter((pole) => !pole.artefact);
  const scope = truth.length ? truth : modes.length ? modes : all;
  const left = Math.min(...scope.map((pole) => pole.re), -1e-3) * 1.5;
  const right = Math.max(...scope.map((pole) => pole.re), 0) + Math.abs(left) * 0.12;
  const high = Math.max(...scope.map((pole) => Math.abs(pole.im)), Math.abs(left) * 0.2) * 1.6;
  const within = (value, least, most) => Math.min(Math.max(value, least), most);
  const x = (re) => within(14 + ((re - left) / (right - left)) * (width - 24), 4, width - 4);
  const y = (im) => within(height / 2 - (im / high) * (height / 2 - 16), 4, height - 4);
  c.strokeStyle = colour("--line");
  c.fillStyle = colour("--weak");
  c.lineWidth = 1;
  c.beginPath();
  c.moveTo(0, y(0));
  c.lineTo(width, y(0));
  c.moveTo(x(0), 0);
  c.lineTo(x(0), height);
  c.stroke();
  c.fillText("real, 1/s", 4, height - 5);
  c.fillText("imaginary, rad/s", x(0) - 94, 12);
  for (const metre of marks(-left)) {
    c.fillRect(x(-metre), y(0) - 3, 1, 6);
    c.fillText(`-${metre}`, x(-metre) - 10, y(0) + 14);
  }
  c.lineWidth = 1.75;
  c.strokeStyle = colour("--c2");
  for (const pole of truth) {
    c.beginPath();
    c.arc(x(pole.re), y(pole.im), 7, 0, 2 * Math.PI);
    c.stroke();
  }
  for (const pole of found) {
    c.strokeStyle = colour(model?.valid && !pole.artefact ? "--c1" : "--weak");
    const [px, py] = [x(pole.re), y(pole.im)];
    c.beginPath();
    for (const sign of [1, -1]) {
      c.moveTo(px - 5, py - 5 * sign);
      c.lineTo(px + 5, py + 5 * sign);
    }
    const [rx, ry] = [2 * pole.re_sd * (width - 24) / (right - left), 2 * pole.im_sd * (height / 2 - 16) / high];
    if (Number.isFinite(rx + ry) && rx + ry > 1) {
      c.moveTo(px - rx, py);
      c.lineTo(px + rx, py);
      c.moveTo(px, py - ry);
      c.lineTo(px, py + ry);
    }
    c.stroke();
  }
  const dominant = found[0];
  const artefacts = found.filter((pole) => pole.artefact).length;
  const text = dominant
    ? `× ${model.name}: dominant pole ${shown(dominant.re)} ${dominant.im < 0 ? "-" : "+"} ${shown(Math.abs(dominant.im))}i 1/s` +
      ` ± ${shown(2 * dominant.re_sd)} (2 sd), fit ${shown(model.fit)} %, ${model.samples} samples` +
      (model.frozen ? ", frozen" : "") + (model.valid ? "" : `; ${model.reason}`) +
      (artefacts ? `; grey: ${artefacts} ${artefacts === 1 ? "pole" : "poles"} too fast to be determined from the samples, ${artefacts === 1 ? "an artefact" : "artefacts"} of sampling` : "")
    : "";
  const true_pole = truth.length ? `○ true (${vehicle.name}): ${shown(truth[0].re)} ± ${shown(Math.abs(truth[0].im))}i 1/s` : "";
  byId("pole_text").textContent = [text, true_pole].filter(Boolean).join("  ");
}
