// Tables of nodes, topics, diagnostics and log; the parameters of every node.

import { ask, byId, el, fill, tell } from "./dom.js";

const LEVELS = { 10: ["debug", "weak"], 20: ["info", ""], 30: ["warning", "warn"], 40: ["error", "bad"], 50: ["fatal", "bad"] };
const GRADES = [["ok", "good"], ["warning", "warn"], ["error", "bad"], ["stale", "weak"]];
const STATES = { alive: "good", silent: "warn", gone: "bad" };
const LINES = 1000;

const body = (id) => byId(id).tBodies[0];
const row = (...cells) => el("tr", {}, ...cells.map((cell) => cell instanceof Node ? cell : el("td", {}, cell)));
const number = (value) => el("td", { className: "number" }, value ?? "–");

/// Whether the tables have what a node or topic of that name says.
let isShown = () => true;
export function showOnly(predicate) {
  isShown = predicate;
}

const named = (list) => list.filter((it) => isShown(it.name));

export function showNodes(nodes) {
  fill(body("nodes"), ...named(nodes).map((node) => row(
    node.name,
    el("td", { className: STATES[node.state] }, node.for == null ? node.state : `${node.state} for ${node.for} s`),
    number(node.published), number(node.refused), number(node.dropped))));
}

export function showTopics(topics) {
  fill(body("topics"), ...named(topics).map((topic) => row(
    topic.name,
    el("td", {}, topic.type, topic.trouble ? el("span", { className: "bad" }, ` ${topic.trouble}`) : ""),
    number(topic.publishers), number(topic.rate), number(topic.lost))));
}

export function showDiagnostics(statuses) {
  const worst = named(statuses).sort((a, b) => b.level - a.level);
  fill(body("diagnostics"), ...worst.map((status) => {
    const [grade, className] = status.stale ? ["silent", "weak"] : GRADES[status.level] ?? [`level ${status.level}`, "bad"];
    const values = status.values.map(([key, value]) => `${key} ${value}`).join(", ");
    return row(el("td", { className }, grade), status.name, el("td", {}, status.message, values ? el("span", { className: "weak" }, ` ${values}`) : ""));
  }));
}

/// The lines of the log that came.
const lines = [];

export function takeLog(more) {
  lines.push(...more);
  if (lines.length > LINES) lines.splice(0, lines.length - LINES);
  // A flood of lines is shown a few times a second.
  waiting ??= setTimeout(() => {
    waiting = undefined;
    showLog();
  }, 200);
}
let waiting;

export function clearLog() {
  lines.length = 0;
}

export function showLog() {
  const least = Number(byId("log_level").value);
  const wanted = byId("log_filter").value.toLowerCase();
  const shown = lines.filter((line) => line.level >= least && isShown(`/${line.node.replaceAll(".", "/")}`) && `${line.node} ${line.text}`.toLowerCase().includes(wanted));
  // The newest first.
  fill(body("log"), ...shown.slice(-300).reverse().map((line) => {
    const [level, className] = LEVELS[line.level] ?? [`level ${line.level}`, "bad"];
    return row(new Date(line.time * 1000).toLocaleTimeString(), el("td", { className }, level), line.node, el("td", { className }, line.text));
  }));
}

/// The parameters of each node that was asked for them, and how often they had changed by then.
const known = new Map();
let changes = {};

/// A node's parameters, asked for again when they have changed.
export async function parametersOf(node) {
  const kept = known.get(node);
  if (kept && kept.changes === changes[node]) return kept.answer;
  const asked = { changes: changes[node], answer: ask({ do: "parameters", node }) };
  known.set(node, asked);
  const answer = await asked.answer;
  if (!answer.ok) known.delete(node);
  return answer;
}

/// Forgets what a node said: it is another process now.
export const forget = (node) => known.delete(node);

/// Takes how often each node's parameters have changed; returns the nodes where that is news.
export function parametersChanged(now) {
  const changed = Object.keys(now).filter((node) => now[node] !== changes[node]);
  changes = now;
  for (const node of changed) openNodes.get(node)?.refresh();
  return changed;
}

export const set = (node, parameter, text) =>
  ask({ do: "set", node, name: parameter.name, kind: parameter.kind, text: String(text), unit: parameter.si });

/// The nodes in the list of parameters.
const openNodes = new Map();

/// Lists the nodes that are alive; their parameters are asked for when a node is opened.
export function showParameters(nodes) {
  const names = named(nodes).filter((node) => node.state !== "gone").map((node) => node.name);
  for (const [name, listed] of openNodes) {
    if (!names.includes(name)) {
      listed.element.remove();
      openNodes.delete(name);
      forget(name);
    }
  }
  for (const name of names) {
    if (openNodes.has(name)) continue;
    const list = el("div");
    const element = el("details", {}, el("summary", {}, name), list);
    const refresh = async () => {
      if (element.open) showValues(list, name, await parametersOf(name));
    };
    element.addEventListener("toggle", refresh);
    openNodes.set(name, { element, refresh });
    const next = [...openNodes.keys()].sort().find((other) => other > name);
    byId("parameters").insertBefore(element, next ? openNodes.get(next).element : null);
  }
}

function showValues(list, node, answer) {
  if (!answer.ok) {
    fill(list, el("p", { className: "bad" }, answer.message));
    return;
  }
  const rows = new Map([...list.children].map((child) => [child.dataset.name, child]));
  for (const parameter of answer.parameters) {
    const shown = rows.get(parameter.name);
    // A value that is being typed stays; so does what came of the last one.
    if (shown?.kind === parameter.kind) {
      const input = shown.querySelector("input, select");
      if (input && document.activeElement !== input) input.value = parameter.text ?? "";
      continue;
    }
    const made = parameterRow(node, parameter);
    if (shown) shown.replaceWith(made);
    else list.append(made);
  }
  list.querySelectorAll(":scope > p").forEach((child) => child.remove());
  filterParameters();
}

function parameterRow(node, parameter) {
  const options = parameter.kind === 1 ? ["true", "false"] : parameter.choices;
  const label = `${node} ${parameter.name}`;
  const input = options
    ? el("select", { ariaLabel: label }, ...options.map((option) => el("option", { value: option }, option)))
    : el("input", { ariaLabel: label, autocomplete: "off", spellcheck: false });
  input.value = parameter.text ?? "";
  input.disabled = parameter.read_only || parameter.kind === 0;
  const output = el("output");
  const send = async () => tell(output, await set(node, parameter, input.value), "set");
  const form = el("form", {}, input);
  if (!input.disabled) form.append(el("button", {}, "Set"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    send();
  });
  const short = (value) => Number(value.toPrecision(6));
  const rules = [
    parameter.range && `from ${short(parameter.range[0])} to ${short(parameter.range[1])} ${parameter.unit}`.trim(),
    parameter.constraints,
    parameter.read_only && "can be set only at the start",
  ].filter(Boolean).join(", ");
  const made = el("div", { className: "parameter" }, el("code", {}, parameter.name), form,
    el("small", {}, parameter.description, parameter.unit ? ` [${parameter.unit}]` : "", rules ? el("i", {}, ` (${rules})`) : ""), output);
  made.dataset.name = parameter.name;
  made.kind = parameter.kind;
  return made;
}

export function filterParameters() {
  const wanted = byId("parameter_filter").value.toLowerCase();
  for (const { element } of openNodes.values()) {
    for (const child of element.querySelectorAll(".parameter")) {
      child.hidden = !child.textContent.toLowerCase().includes(wanted);
    }
  }
}
