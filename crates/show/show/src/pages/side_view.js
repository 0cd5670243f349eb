"use strict";
// The side view: the vehicle at the instant of its slider, of the plots' cursor, or of its own clock.
for (const figure of document.querySelectorAll("figure.side")) {
  // Each instant: time, depth, pitch and planes in degrees, and the place in the picture.
  const instants = JSON.parse(figure.querySelector("script").textContent);
  const [hull, slider, output, play] = ["g.hull", "input", "output", "button"].map((it) => figure.querySelector(it));
  const planes = figure.querySelectorAll(".plane");
  const signed = (value, digits) => `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;

  function show(k) {
    const [time, depth, pitch, plane, x, y] = instants[k];
    // Bow up is a turn to the left, planes to dive have their leading edge down.
    hull.setAttribute("transform", `translate(${x} ${y}) rotate(${-pitch})`);
    planes.forEach((it, i) => it.setAttribute("transform", `rotate(${i === 0 ? plane : -plane})`));
    output.textContent = `${time.toFixed(1)} s  depth ${depth.toFixed(3)} m  pitch ${signed(pitch, 1)}°  planes ${signed(plane, 1)}°`;
    slider.value = k;
  }

  let clock = null;
  function stop() {
    clearInterval(clock);
    clock = null;
    play.textContent = "Play";
  }
  play.addEventListener("click", () => {
    if (clock) { stop(); return; }
    let k = Number(slider.value) % (instants.length - 1);
    play.textContent = "Stop";
    clock = setInterval(() => { show(k); k += 1; if (k >= instants.length) stop(); }, 40);
  });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  document.addEventListener("instant", ({ detail: { x, quantity } }) => {
    if (quantity !== "time [s]" || x == null || clock) return;
    const [from, to] = [instants[0][0], instants.at(-1)[0]];
    const k = Math.round((x - from) / (to - from) * (instants.length - 1));
    show(Math.max(0, Math.min(instants.length - 1, k)));
  });
  // At first where the vehicle is tilted most.
  const tilt = instants.map((it) => Math.abs(it[2]));
  show(tilt.indexOf(Math.max(...tilt)));
}
