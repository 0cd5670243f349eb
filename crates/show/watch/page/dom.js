// Elements made of text only, and requests to the program. Nothing of other nodes ever becomes HTML.

export const byId = (id) => document.getElementById(id);

/// An element with properties and children; a child that is no element becomes text.
export function el(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children.map((child) => child instanceof Node ? child : String(child ?? "")));
  return made;
}

/// Puts these children in place of what an element has.
export function fill(element, ...children) {
  element.replaceChildren(...children);
}

/// Asks the program to do something; the answer has `ok` and `message`, and `denied` where this page may not ask at all.
export async function ask(command) {
  try {
    const response = await fetch("do", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(command),
    });
    const denied = !response.headers.get("Content-Type")?.includes("json");
    return denied ? { ok: false, denied, message: (await response.text()).trim() } : await response.json();
  } catch {
    return { ok: false, message: "no connection to planesman watch" };
  }
}

/// Tells beside a control what came of it.
export function tell(output, answer, done = "done") {
  output.className = answer.ok ? "good" : "bad";
  output.textContent = answer.message || (answer.ok ? done : "refused");
  return answer.ok;
}

/// A number with so many significant digits, without an exponent where it is short.
export function shown(value, digits = 4) {
  if (value === undefined || value === null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(digits - 1);
  const decimals = size === 0 ? 2 : Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(decimals, digits));
}

/// The units in which the page has quantities, by their SI units, where they differ: the program's own list.
let units = {};
export async function readUnits() {
  units = await (await fetch("units")).json();
}

/// A quantity's unit on the page, and what one of its SI unit is in it.
export const unitOf = (si) => units[si] ?? { symbol: si, scale: 1 };

/// The colour of that name as the style sheet has it.
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/// Offers a file for saving.
export function save(name, blob) {
  const link = el("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/// A canvas fitted to its place, its context scaled to CSS pixels, and its size.
export function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
