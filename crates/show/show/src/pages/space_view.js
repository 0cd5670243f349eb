"use strict";
// The view in space: hull, fins, thrusters and track as lines, turned by dragging, at the instant of the flight's side view.
for (const figure of document.querySelectorAll("figure.space")) {
  const { instants, lines } = JSON.parse(figure.querySelector("script").textContent);
  const canvas = figure.querySelector("canvas");
  const ink = canvas.getContext("2d");
  const colour = (name) => getComputedStyle(figure).getPropertyValue(name).trim();
  let [turn, tilt, zoom, at] = [-0.6, 0.5, 1, instants.length - 1];

  // North, east, down; the middle of the track and its extent.
  const low = [1, 2, 3].map((i) => Math.min(...instants.map((it) => it[i])));
  const high = [1, 2, 3].map((i) => Math.max(...instants.map((it) => it[i])));
  const middle = low.map((it, i) => (it + high[i]) / 2);
  const extent = Math.max(...high.map((it, i) => it - low[i]), 1e-3);
  const length = Math.max(...lines.flat().map((it) => Math.abs(it[0]))) * 2;
  // The hull is drawn large enough to be seen.
  const scale = Math.max(1, extent / (8 * length));

  function project([north, east, down]) {
    const [x, y, z] = [north - middle[0], east - middle[1], down - middle[2]];
    const [s, c] = [Math.sin(turn), Math.cos(turn)];
    const [across, away] = [y * c - x * s, x * c + y * s];
    const unit = zoom * Math.min(canvas.width, canvas.height * 1.4) / (1.5 * extent + 2 * length * scale);
    return [canvas.width / 2 + unit * across, canvas.height / 2 + unit * (z * Math.cos(tilt) - away * Math.sin(tilt))];
  }

  // The rotation of roll, pitch and yaw on a place of the body, in the fixed frame.
  function placed([x, y, z], [, north, east, down, roll, pitch, yaw]) {
    const [sr, cr, sp, cp, sy, cy] = [roll, pitch, yaw].flatMap((it) => [Math.sin(it), Math.cos(it)]);
    const [below, aside] = [y * sr + z * cr, y * cr - z * sr];
    const ahead = x * cp + below * sp;
    return [north + scale * (ahead * cy - aside * sy), east + scale * (ahead * sy + aside * cy), down + scale * (below * cp - x * sp)];
  }

  function line(points, style, width) {
    ink.beginPath();
    points.forEach((it, i) => ink[i === 0 ? "moveTo" : "lineTo"](...project(it)));
    ink.strokeStyle = style;
    ink.lineWidth = width;
    ink.stroke();
  }

  function draw() {
    ink.clearRect(0, 0, canvas.width, canvas.height);
    const floor = high[2];
    line([[low[0], low[1], floor], [high[0], low[1], floor], [high[0], high[1], floor], [low[0], high[1], floor], [low[0], low[1], floor]], colour("--muted"), 1);
    line(instants.map((it) => it.slice(1, 4)), colour("--series-1"), 2);
    for (const part of lines) line(part.map((it) => placed(it, instants[at])), colour("--text"), 1.5);
    figure.querySelector("output").textContent = `${instants[at][0].toFixed(1)} s  drawn ${scale.toFixed(1)} times as large`;
  }

  let from = null;
  canvas.addEventListener("pointerdown", (it) => { from = [it.clientX, it.clientY]; canvas.setPointerCapture(it.pointerId); });
  canvas.addEventListener("pointerup", () => { from = null; });
  canvas.addEventListener("pointermove", (it) => {
    if (!from) return;
    turn += (it.clientX - from[0]) / 150;
    tilt = Math.max(-1.5, Math.min(1.5, tilt + (it.clientY - from[1]) / 150));
    from = [it.clientX, it.clientY];
    draw();
  });
  const slider = figure.querySelector("input");
  slider.addEventListener("input", () => { at = Number(slider.value); draw(); });
  figure.querySelector("button").addEventListener("click", () => { zoom = zoom > 3 ? 1 : zoom * 1.5; draw(); });
  document.addEventListener("instant", ({ detail: { x, quantity } }) => {
    if (quantity !== "time [s]" || x == null) return;
    const [first, last] = [instants[0][0], instants.at(-1)[0]];
    at = Math.max(0, Math.min(instants.length - 1, Math.round((x - first) / (last - first) * (instants.length - 1))));
    slider.value = at;
    draw();
  });
  new MutationObserver(draw).observe(document.documentElement, { attributes: true });
  draw();
}
