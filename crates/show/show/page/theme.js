"use strict";
// The theme: the system's, light or dark; and the colours of theme.css for what draws on a canvas.
const theme = (() => {
  const root = document.documentElement;
  const names = ["auto", "light", "dark"];
  const listeners = [];
  const probe = document.createElement("span");
  probe.hidden = true;
  let known = new Map();

  // A page that is opened as a file may have no storage.
  const stored = () => { try { return localStorage.getItem("theme"); } catch { return null; } };
  const store = (name) => { try { localStorage.setItem("theme", name); } catch { /* not kept */ } };

  // The colour of a custom property, as the canvas takes it.
  function colour(name) {
    if (!known.has(name)) {
      if (!probe.isConnected) document.body.append(probe);
      probe.style.color = `var(${name})`;
      known.set(name, getComputedStyle(probe).color);
    }
    return known.get(name);
  }

  function changed() {
    known = new Map();
    for (const listener of listeners) listener();
  }

  function set(name) {
    if (name === "auto") delete root.dataset.theme; else root.dataset.theme = name;
    changed();
  }

  // A button that goes through the three.
  function button() {
    const it = document.createElement("button");
    it.className = "theme";
    it.type = "button";
    let name = names.includes(stored()) ? stored() : "auto";
    const show = () => { it.textContent = `Theme: ${name}`; set(name); };
    it.addEventListener("click", () => {
      name = names[(names.indexOf(name) + 1) % names.length];
      store(name);
      show();
    });
    show();
    return it;
  }

  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  return { colour, button, set, onChange: (listener) => listeners.push(listener), isSet: () => root.dataset.theme ?? "auto" };
})();
