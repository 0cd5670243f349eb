// What an operator does with a vehicle: mode, setpoints, manoeuvres, pause, identification, faults, recording.

import { ask, byId, el, fill, shown, tell, unitOf } from "./dom.js";
import { parametersOf, set } from "./tables.js";

const MANOEUVRES = ["step", "pulse", "doublet", "square", "sinusoid", "prbs", "chirp", "run_7_3", "run_7_5", "run_8_1", "run_9_1", "run_9_2"];

let place = "";
let panel = {};

const button = (text, onclick) => el("button", { type: "button", onclick }, text);
const count = (label, value) => el("input", { type: "number", value, step: 1, min: 1, ariaLabel: label });

/// A quantity as text: a number in the unit that stands beside it, or with a unit of its own, which the program reads.
const amount = (label, value) => el("input", { value, className: "amount", ariaLabel: label, autocomplete: "off", spellcheck: false, title: "a number, with or without a unit: 1ft, 10deg" });
const named = (name, si) => `${name} [${unitOf(si).symbol}]`;

/// A group of controls with the place where it is told what came of them.
function group(title, ...rows) {
  const output = el("output");
  const element = el("div", {}, el("h3", {}, title), ...rows.map((row) => el("div", { className: "row" }, ...row)), output);
  return { element, output };
}

/// A button that asks the program to do something and tells what came of it.
function doing(text, output, command) {
  return button(text, async () => tell(output(), await ask(command())));
}

/// Builds the panel of the vehicle in that namespace; the setpoints have names and SI units.
export function operate(namespace, list) {
  place = namespace;
  const at = (name) => `${place}/${name}`;
  panel = {};
  panel.mode = group("Mode", [(panel.modes = el("span", { className: "row" }))]);
  const setpoints = list.map(([name, si]) => {
    const input = amount(`${name} setpoint`, "");
    const send = async () => tell(panel.setpoints.output, await ask({ do: "publish", topic: at(`${name}_setpoint`), text: input.value }), "sent");
    const form = el("form", { className: "row" }, input, el("button", {}, "Send"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      send();
    });
    return [el("span", { className: "name" }, named(name, si)), form];
  });
  panel.setpoints = group("Setpoints", ...setpoints);

  const name = el("select", { ariaLabel: "manoeuvre" }, ...MANOEUVRES.map((it) => el("option", { value: it }, it)));
  const [amplitude, period, duration] = [amount("amplitude", 5), amount("period", 4), amount("duration", 20)];
  const fly = () => ({
    do: "manoeuvre",
    action: at("depth_controller/manoeuvre"),
    goal: { name: name.value, amplitude: amplitude.value, period: period.value, duration: duration.value },
  });
  const output = () => panel.manoeuvre.output;
  panel.manoeuvre = group("Manoeuvre",
    [name, named("amplitude", "rad"), amplitude],
    [named("period", "s"), period, named("duration", "s"), duration],
    [doing("Fly", output, fly), doing("Cancel", output, () => ({ do: "cancel", action: at("depth_controller/manoeuvre") }))]);
  panel.progress = el("p", { className: "weak", id: "progress" });
  panel.manoeuvre.element.append(panel.progress);

  const ticks = count("ticks", 20);
  const pause = (data) => () => ({ do: "set_bool", service: at("plant_sim/pause"), data });
  const simulation = () => panel.simulation.output;
  panel.simulation = group("Simulation",
    [doing("Pause", simulation, pause(true)), doing("Go on", simulation, pause(false)),
      doing("Step", simulation, () => ({ do: "step", service: at("plant_sim/step"), ticks: Math.max(1, Math.round(Number(ticks.value))) })), ticks, "ticks"],
    [doing("Reset the vehicle", simulation, () => ({ do: "trigger", service: at("plant_sim/reset") })),
      doing("Reset the fault", simulation, () => ({ do: "trigger", service: at("depth_controller/reset_fault") }))]);

  const identification = () => panel.identification.output;
  const freeze = (data) => () => ({ do: "set_bool", service: at("sysid/freeze"), data });
  panel.identification = group("Identification",
    [doing("Fit", identification, () => ({ do: "fit", service: at("sysid/fit"), name: "" })),
      doing("Freeze", identification, freeze(true)), doing("Learn", identification, freeze(false)),
      doing("Reset", identification, () => ({ do: "trigger", service: at("sysid/reset") }))]);

  panel.faults = group("Faults of the actuator", [(panel.fault = el("div"))]);

  const recording = (service) => () => ({ do: "recorder", service: at(`recorder/${service}`) });
  const recorder = () => panel.recorder.output;
  panel.recorder = group("Recorder", [(panel.bag = el("span"))],
    [doing("Pause", recorder, recording("pause")), doing("Resume", recorder, recording("resume")), doing("Next file", recorder, recording("split_bagfile"))]);

  const groups = ["mode", "setpoints", "manoeuvre", "simulation", "identification", "faults", "recorder"];
  fill(byId("operate"), el("h2", {}, "Operate"), ...groups.map((it) => panel[it].element));
  for (const it of groups) panel[it].element.hidden = true;
}

/// Shows the groups whose services there are.
export function offered(services) {
  const has = (name) => services.includes(`${place}/${name}`);
  panel.simulation.element.hidden = !has("plant_sim/pause");
  panel.identification.element.hidden = !has("sysid/fit");
  panel.recorder.element.hidden = !has("recorder/split_bagfile");
  panel.manoeuvre.element.hidden = !has("depth_controller/manoeuvre/_action/send_goal");
  panel.setpoints.element.hidden = !has("depth_controller/reset_fault");
}

/// Reads mode and faults anew from the parameters of controller and actuator.
export async function refresh(alive) {
  const asked = place;
  const [controller, actuator] = [`${place}/depth_controller`, `${place}/dha_actuator`];
  const answers = await Promise.all([controller, actuator].map((node) => alive.includes(node) ? parametersOf(node) : { ok: false }));
  if (asked !== place) return;
  const mode = answers[0].ok && answers[0].parameters.find((it) => it.name === "mode");
  panel.mode.element.hidden = !mode;
  if (mode) {
    fill(panel.modes, ...(mode.choices ?? []).map((choice) => chosen(choice, choice === mode.text, panel.mode.output, controller, mode, choice)));
  }
  const faults = answers[1].ok ? answers[1].parameters.filter((it) => it.name.startsWith("fault.") && it.name !== "fault.group") : [];
  panel.faults.element.hidden = !faults.length;
  fill(panel.fault, ...faults.map((fault) => {
    const values = fault.choices ?? severities(fault);
    const label = fault.name.slice("fault.".length).replaceAll("_", " ");
    return el("div", {}, el("div", { className: "row" }, el("span", { className: "name" }, label),
      ...values.map((value) => chosen(fault.unit ? `${value} ${fault.unit}` : value, String(value) === fault.text, panel.faults.output, actuator, fault, value))),
    el("small", { className: "weak" }, fault.description));
  }));
}

/// None, half and all of a fault that has a range.
function severities(fault) {
  const [least, most] = fault.range ?? [0, 1];
  return [least, (least + most) / 2, most].map((it) => Number(it.toPrecision(3)));
}

function chosen(text, on, output, node, parameter, value) {
  const made = button(text, async () => tell(output, await set(node, parameter, value), `${parameter.name}: ${text}`));
  if (on) made.className = "on";
  made.setAttribute("aria-pressed", on);
  return made;
}

/// How a manoeuvre goes.
export function progress(sections) {
  const angle = unitOf("rad");
  const flown = sections[`manoeuvre:${place}/depth_controller/manoeuvre`];
  if (!flown) {
    panel.progress.textContent = "";
    return;
  }
  const running = flown.elapsed === undefined ? "" : `, ${shown(flown.elapsed)} s, planes ${shown(flown.dive_planes * angle.scale)} ${angle.symbol}`;
  panel.progress.textContent = flown.state + running + (flown.message ? `: ${flown.message}` : "");
}

/// What the recorder does, with a link to its bag.
export function recording(statuses) {
  const status = statuses.find((it) => it.name === `${place}/recorder: bag`);
  if (!status) {
    fill(panel.bag);
    return;
  }
  const value = (key) => status.values.find(([name]) => name === key)?.[1];
  const file = value("file") ?? "";
  fill(panel.bag, `${status.message}, ${value("messages") ?? "–"} messages, ${value("lost") ?? "–"} lost, `,
    el("a", { href: `bag?node=${encodeURIComponent(`${place}/recorder`)}`, title: file, download: "" }, file.split("/").at(-1)));
}
