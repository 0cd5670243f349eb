"use strict";
// Draws the plots of a page. A plot is <figure class="plot"> with its data as JSON beside the heading (crates/show/show/src/plot/series.rs
// and heat_map.rs say what it holds). uPlot draws axes and grid and has cursor, zoom and scales; the series are painted here, each
// over its own x values. Plots over the same quantity have one cursor; linked ones one zoom too. Text of others goes in by textContent only.
(() => {
  const POINTS = ["crosses", "circles", "squares", "diamonds", "dots"];
  const SHADES = ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#fde725"];
  const NEAR = 40; // px from the cursor to a point that it names
  const STAR = "★"; // marks the best field of a heat map
  const groups = new Map(); // linked x axes: name to drawings
  const drawings = [];

  const make = (tag, name, text) => {
    const it = document.createElement(tag);
    if (name) it.className = name;
    if (text !== undefined) it.textContent = text;
    return it;
  };

  // A number in so many digits, without the zeros at its end.
  function number(value, digits = 5) {
    if (value == null || !Number.isFinite(value)) return "–";
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(digits - 2).replace("e+", "e");
    return String(Number(value.toPrecision(digits)));
  }

  // A text in this font, as wide as it is drawn, px.
  const pen = document.createElement("canvas").getContext("2d");
  const FONT = "12px system-ui, sans-serif";
  function width(text, font = FONT) {
    pen.font = font;
    return pen.measureText(text).width;
  }

  // The text, its middle left out where it is longer than there is room.
  function fitted(text, room) {
    for (let kept = text.length; kept > 4; kept -= 1) {
      const it = kept === text.length ? text : `${text.slice(0, Math.ceil(kept / 2))}…${text.slice(-Math.floor(kept / 2))}`;
      if (width(it) <= room) return it;
    }
    return text.slice(0, 4);
  }

  // The labels of an axis, all with the decimals that their distance needs.
  function labels(plot, splits, _axis, _space, step) {
    const most = Math.max(...splits.map(Math.abs));
    if (most >= 1e6 || (most > 0 && most < 1e-3)) return splits.map((it) => (it === 0 ? "0" : it.toExponential(1).replace("e+", "e")));
    const decimals = Math.min(6, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    const exact = decimals < 6 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6 ? decimals + 1 : decimals;
    return splits.map((it) => (it == null ? "" : (Math.abs(it) < step / 1e6 ? 0 : it).toFixed(exact)));
  }

  // A logarithmic axis: lines at 1 to 9 of each decade, numbers at as many of them as have room.
  const decades = {
    splits: (_plot, _axis, low, high) => {
      const splits = [];
      for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power += 1) {
        for (let digit = 1; digit < 10; digit += 1) {
          const it = Number(`${digit}e${power}`);
          if (it >= low && it <= high) splits.push(it);
        }
      }
      return splits;
    },
    values: (_plot, splits) => {
      const span = splits.length ? splits[splits.length - 1] / splits[0] : 1;
      const told = span > 30 ? "1" : span > 5 ? "125" : "123456789";
      return splits.map((it) => (told.includes(it.toExponential()[0]) ? number(it, 3) : ""));
    },
    filter: (_plot, splits) => splits,
  };


  // x values: a list, or [first, last, count] of equal distances.
  const xs = (it) => (Array.isArray(it) ? it : Array.from({ length: it.count }, (_, k) =>
    (it.count > 1 ? it.first + (it.last - it.first) * k / (it.count - 1) : it.first)));

  // The first index whose x is not below.
  function place(x, value) {
    let [low, high] = [0, x.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x[middle] < value) low = middle + 1; else high = middle;
    }
    return low;
  }

  function bounds(lists) {
    let [low, high] = [Infinity, -Infinity];
    for (const list of lists) for (const it of list) { if (it < low) low = it; if (it > high) high = it; }
    return low > high ? null : [low, high];
  }

  // Below this a range has no ticks, and a number is the rounding of zero.
  const LEAST = 1e-12;

  // A range with air; around a constant as much as shows that it is one.
  function airy([low, high], share) {
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (high - low <= 1e-9 * size || high - low < LEAST) {
      const half = size < LEAST ? 1 : 0.1 * size;
      return [low - half, high + half];
    }
    return [low - share * (high - low), high + share * (high - low)];
  }

  class Drawing {
    constructor(figure) {
      this.figure = figure;
      this.data = JSON.parse(figure.querySelector("script").textContent);
      this.area = figure.querySelector(".area");
      this.legend = figure.querySelector(".legend");
      this.series = (this.data.series ?? []).map((it) => ({ ...it, x: xs(it.x), shown: true }));
      // In a plane a point is found by its distance, over a course by its x.
      this.isPlane = Boolean(this.data.plane);
      this.full = this.whole();
      this.list();
      this.chart = new uPlot(this.options(), [[this.full.x[0], this.full.x[1]], [null, null]], this.area);
      new ResizeObserver(() => requestAnimationFrame(() => this.fit())).observe(figure);
      this.area.setAttribute("role", "img");
      this.area.setAttribute("aria-label", this.words());
      this.area.tabIndex = 0;
      this.area.addEventListener("keydown", (event) => this.key(event));
      this.area.addEventListener("blur", () => this.leave());
    }

    size(across = this.area.clientWidth) {
      const fields = this.data.rows?.length ?? 0;
      const height = this.data.heat ? Math.min(560, Math.max(180, 30 * fields + 70, width(this.data.y) + 75))
        : this.data.equal ? Math.min(460, Math.max(280, 0.75 * across)) : Math.min(320, Math.max(210, 0.42 * across));
      return { width: Math.max(200, across), height: Math.round(height) };
    }

    fit(across) {
      const { width: before } = this.chart;
      const size = this.size(across);
      if (size.width === before) return;
      this.chart.setSize(size);
      this.settle();
    }

    // Equal scales follow the size, which uPlot knows once it has placed the axes, at the end of this task.
    settle() {
      if (this.data.equal) queueMicrotask(() => this.show(...this.seen, false));
    }

    whole() {
      const { data } = this;
      if (data.heat) return { x: [-0.5, data.columns.length - 0.5], y: [-0.5, data.rows.length - 0.5] };
      const x = bounds(this.series.map((it) => it.x)) ?? [0, 1];
      if (data.zero) { x[0] = Math.min(0, x[0]); x[1] = Math.max(0, x[1]); }
      const air = data.log ? x : airy(x, this.isPlane ? 0.06 : data.equal ? 0.05 : 0);
      return { x: air, y: this.isPlane ? airy(bounds(this.series.map((it) => it.y)) ?? [0, 1], 0.06) : null };
    }

    // The y values between two x values, lines cut at both.
    heights([from, to]) {
      let range = null;
      const take = (y) => { range = range ? [Math.min(range[0], y), Math.max(range[1], y)] : [y, y]; };
      for (const { x, y, style, shown } of this.series) {
        if (!shown) continue;
        if (style === "area") { x.forEach((at, k) => { if (at >= from && at <= to) take(y[k]); }); continue; }
        const [first, last] = [place(x, from), place(x, to)];
        for (let k = first; k < x.length && x[k] <= to; k += 1) take(y[k]);
        for (const [k, at] of [[first, from], [last, to]]) {
          if (k > 0 && k < x.length && x[k] > x[k - 1]) take(y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1]));
        }
      }
      return airy(range ?? [0, 1], 0.06);
    }

    // Shows these ranges; y follows the data where none is given. `linked` passes x on to the plots of the same group.
    show(x, y, linked = true) {
      let [xr, yr] = [x, y ?? this.heights(x)];
      this.seen = [x, y];
      if (this.data.equal) [xr, yr] = this.equal(xr, yr);
      this.chart.batch(() => {
        this.chart.setScale("x", { min: xr[0], max: xr[1] });
        this.chart.setScale("y", { min: yr[0], max: yr[1] });
      });
      if (linked) for (const other of this.linked()) other.show(x, null, false);
    }

    linked() { return (groups.get(this.data.link) ?? []).filter((it) => it !== this); }

    // A unit is as long on one axis as on the other.
    equal([x0, x1], [y0, y1]) {
      const { clientWidth: w, clientHeight: h } = this.chart.over;
      if (!w || !h) return [[x0, x1], [y0, y1]];
      const half = Math.max((x1 - x0) / w, (y1 - y0) / h) / 2;
      const [x, y] = [(x0 + x1) / 2, (y0 + y1) / 2];
      return [[x - half * w, x + half * w], [y - half * h, y + half * h]];
    }

    reset() {
      this.show(this.full.x, this.full.y, false);
      for (const other of this.linked()) other.show(other.full.x, null, false);
    }

    options() {
      const { data } = this;
      const size = this.size();
      const given = (_plot, low, high) => [low, high];
      const axis = (label, more) => ({
        label, labelSize: 20, labelGap: 2, font: FONT, labelFont: FONT,
        stroke: () => theme.colour("--muted"), grid: { stroke: () => theme.colour("--grid"), width: 1 },
        ticks: { stroke: () => theme.colour("--rule"), width: 1, size: 4 }, ...more,
      });
      // Names of fields, as many as have room.
      const names = (list, room, side) => ({
        splits: (plot, _axis, low, high) => {
          const every = Math.max(1, Math.ceil(list.length * room / (plot.over[side] || size.width)));
          return list.map((_, k) => k).filter((k) => k % every === 0 && k >= low && k <= high);
        },
        values: (_plot, splits) => splits.map((k) => list[k] ?? ""),
        grid: { show: false },
      });
      // One cursor for all plots over one quantity, and for all heat maps over one pair.
      const shared = data.heat ? JSON.stringify([data.x, data.y, data.columns, data.rows]) : this.isPlane ? "" : data.x;
      // Equal scales need a width that does not follow the labels.
      const widest = (_plot, values) => data.equal ? 56 : 14 + Math.max(21, ...(values ?? []).map((it) => width(String(it ?? ""))));
      const x = data.heat ? names(data.columns, 10 + Math.max(...data.columns.map((it) => width(it))), "clientWidth") : data.log ? decades : { values: labels };
      const y = data.heat ? names(data.rows, 16, "clientHeight") : { values: labels };
      return {
        ...size, legend: { show: false }, padding: [10, 14, 0, 0],
        scales: { x: { time: false, range: given, distr: data.log ? 3 : 1 }, y: { range: given, auto: false, dir: data.down ? -1 : 1 } },
        axes: [axis(data.x, { size: 28, ...x }), axis(fitted(data.y, size.height - 70), { size: widest, ...y })],
        series: [{}, { show: false }],
        cursor: {
          points: { show: false }, y: this.isPlane || Boolean(data.heat),
          drag: { x: !data.heat, y: this.isPlane, setScale: false },
          bind: { dblclick: () => () => this.reset() },
          ...(shared ? { sync: { key: shared, scales: ["x", data.heat ? "y" : null], filters: { pub: (type) => type === "mousemove" } } } : {}),
        },
        hooks: {
          ready: [(chart) => { this.chart = chart; this.show(this.full.x, this.full.y, false); this.settle(); }],
          draw: [() => this.paint()], setCursor: [() => this.hover()], setSelect: [() => this.zoom()],
        },
      };
    }

    zoom() {
      const { chart } = this;
      const { left, top, width, height } = chart.select;
      if (width < 5 || (this.isPlane && height < 5)) return;
      const pair = (a, b) => [Math.min(a, b), Math.max(a, b)];
      const x = pair(chart.posToVal(left, "x"), chart.posToVal(left + width, "x"));
      const y = this.isPlane ? pair(chart.posToVal(top, "y"), chart.posToVal(top + height, "y")) : null;
      const tooSmall = ([low, high]) => high - low <= 1e-9 * Math.max(Math.abs(low), Math.abs(high)) || high - low < LEAST;
      chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      if (!tooSmall(x) && !(y && tooSmall(y))) this.show(x, y);
    }

    colour(series) { return theme.colour(series.colour ? `--series-${(series.colour - 1) % 8 + 1}` : "--text"); }

    paint() {
      const { chart, data } = this;
      const { ctx } = chart;
      const { left, top, width, height } = chart.bbox;
      const px = uPlot.pxRatio;
      ctx.save();
      ctx.beginPath();
      ctx.rect(left, top, width, height);
      ctx.clip();
      ctx.lineJoin = "round";
      if (data.heat) this.fields(ctx);
      if (this.range) {
        const [a, b] = this.range.map((x) => chart.valToPos(x, "x", true));
        ctx.fillStyle = theme.colour("--accent");
        ctx.globalAlpha = 0.25;
        ctx.fillRect(a, top, Math.max(b - a, 2 * px), height);
      }
      for (const it of this.series) if (it.shown) this.one(ctx, it, px);
      ctx.restore();
    }

    one(ctx, series, px) {
      const { chart } = this;
      const { x, y, style } = series;
      const across = (k) => chart.valToPos(x[k], "x", true);
      const down = (k) => chart.valToPos(y[k], "y", true);
      ctx.strokeStyle = ctx.fillStyle = this.colour(series);
      ctx.globalAlpha = 1;
      // The ninth and later series have the colours of the first again, dashed.
      ctx.setLineDash(series.colour > 8 ? [8 * px, 3 * px] : []);
      ctx.beginPath();
      if (POINTS.includes(style)) {
        const r = { crosses: 4.5, circles: 5.5, squares: 4, diamonds: 5.5, dots: 1.3 }[style] * px;
        for (let k = 0; k < x.length; k += 1) {
          const [a, b] = [across(k), down(k)];
          if (style === "crosses") {
            ctx.moveTo(a - r, b - r); ctx.lineTo(a + r, b + r);
            ctx.moveTo(a - r, b + r); ctx.lineTo(a + r, b - r);
          } else if (style === "squares") {
            ctx.rect(a - r, b - r, 2 * r, 2 * r);
          } else if (style === "diamonds") {
            ctx.moveTo(a + r, b); ctx.lineTo(a, b + r); ctx.lineTo(a - r, b); ctx.lineTo(a, b - r); ctx.closePath();
          } else {
            ctx.moveTo(a + r, b);
            ctx.arc(a, b, r, 0, 2 * Math.PI);
          }
        }
        ctx.lineWidth = 1.8 * px;
        if (style === "dots") ctx.fill(); else ctx.stroke();
        return;
      }
      for (let k = 0; k < x.length; k += 1) if (k) ctx.lineTo(across(k), down(k)); else ctx.moveTo(across(k), down(k));
      if (style === "area") {
        ctx.globalAlpha = 0.2;
        ctx.fill();
      } else {
        ctx.lineWidth = { dashed: 1.4, bound: 1.2, grid: 0.8, broad: 5 }[style] * px || 1.7 * px;
        if (style === "dashed" || style === "bound") ctx.setLineDash([6 * px, 4 * px]);
        if (style === "broad" || style === "grid") ctx.globalAlpha = 0.4;
        ctx.stroke();
      }
      ctx.globalAlpha = 1;
      ctx.setLineDash([]);
    }

    fields(ctx) {
      const { chart, data } = this;
      const px = uPlot.pxRatio;
      const side = (k, scale) => chart.valToPos(k, scale, true);
      const [wide, high] = [side(1, "x") - side(0, "x"), side(0, "y") - side(1, "y")];
      // Across, or upwards where the fields are narrow.
      const across = this.told(wide - 6 * px, high, px);
      const text = across ?? this.told(high - 6 * px, wide, px);
      ctx.textAlign = "center";
      ctx.textBaseline = "middle";
      data.heat.forEach((row, r) => row.forEach((value, c) => {
        const [a, b] = [side(c - 0.5, "x"), side(r + 0.5, "y")];
        if (value != null) {
          const shade = this.shade(value);
          ctx.fillStyle = `rgb(${shade.join(" ")})`;
          ctx.fillRect(a, b, wide + 0.5, high + 0.5);
          // Black or white, whichever stands out more.
          ctx.fillStyle = shade[0] * 0.299 + shade[1] * 0.587 + shade[2] * 0.114 > 115 ? "#000" : "#fff";
        } else {
          ctx.fillStyle = theme.colour("--muted");
        }
        if (text) {
          ctx.save();
          ctx.translate(a + wide / 2, b + high / 2);
          if (!across) ctx.rotate(-Math.PI / 2);
          ctx.fillText(text(value, this.isBest(r, c)), 0, 0);
          ctx.restore();
        }
        if (!this.isBest(r, c)) return;
        ctx.setLineDash([]);
        for (const [ink, thick] of [["#000", 5], ["#fff", 2]]) {
          ctx.strokeStyle = ink;
          ctx.lineWidth = thick * px;
          ctx.strokeRect(a + 2.5 * px, b + 2.5 * px, wide - 5 * px, high - 5 * px);
        }
      }));
    }

    isBest(row, column) { return this.data.best?.[0] === row && this.data.best[1] === column; }

    // How the numbers are written in fields of this size: in as many digits as have room, at most four; not at all where not even two have.
    told(wide, high, px) {
      const { chart, data } = this;
      if (high < 13 * px) return null;
      chart.ctx.font = `${12 * px}px system-ui, sans-serif`;
      for (const digits of [4, 3, 2]) {
        const text = (value, isBest) => (isBest ? `${STAR} ` : "") + number(value, digits);
        const widest = Math.max(...data.heat.flatMap((row, r) => row.map((it, c) => chart.ctx.measureText(text(it, this.isBest(r, c))).width)));
        if (widest <= wide) return text;
      }
      return null;
    }

    shade(value) {
      const [low, high] = this.data.range;
      const at = (high > low ? (value - low) / (high - low) : 0.5) * (SHADES.length - 1);
      const below = Math.min(SHADES.length - 2, Math.floor(at));
      const part = (hex, k) => parseInt(hex.slice(1 + 2 * k, 3 + 2 * k), 16);
      const mixed = [0, 1, 2].map((k) => Math.round(part(SHADES[below], k) + (at - below) * (part(SHADES[below + 1], k) - part(SHADES[below], k))));
      return mixed;
    }

    // The series by name, each a button that hides it, with its value at the cursor.
    list() {
      this.at = make("span", "at", "");
      if (this.data.heat) {
        const shades = make("span", "shades");
        shades.style.background = `linear-gradient(to right, ${SHADES.join(", ")})`;
        const [low, high] = this.data.range;
        const scale = make("span", "", `${this.data.quantity}: ${number(low)}`);
        scale.append(shades, number(high));
        this.legend.append(scale);
        if (this.data.best) this.legend.append(make("span", "best", `${STAR} best: ${this.field(...this.data.best)}`));
        this.legend.append(this.at);
        return;
      }
      for (const it of this.series) {
        const button = make("button");
        button.type = "button";
        button.title = "show or hide";
        button.setAttribute("aria-pressed", "true");
        it.mark = mark(it);
        it.value = make("output");
        button.append(it.mark, make("span", "", it.name));
        if (!this.isPlane && it.style !== "area") button.append(it.value);
        // The second and later parts of an area have no name.
        if (!it.name) continue;
        button.addEventListener("click", () => {
          const parts = this.series.filter((other, k) => other === it || (!other.name && this.named(k) === it));
          parts.forEach((part) => { part.shown = !part.shown; });
          button.setAttribute("aria-pressed", String(it.shown));
          this.show(...this.seen, false);
          this.chart.redraw();
        });
        this.legend.append(button);
      }
      this.legend.append(this.at);
    }

    // The series that a part without a name belongs to.
    named(k) {
      while (k > 0 && !this.series[k].name) k -= 1;
      return this.series[k];
    }

    dot(series) {
      if (!series.dot) {
        series.dot = make("div", "dot");
        this.chart.over.append(series.dot);
      }
      return series.dot;
    }

    mark(series, x, y) {
      const dot = this.dot(series);
      dot.style.display = x == null ? "none" : "block";
      if (x == null) return;
      dot.style.background = this.colour(series);
      dot.style.transform = `translate(${this.chart.valToPos(x, "x")}px, ${this.chart.valToPos(y, "y")}px)`;
    }

    hover() {
      const { chart, data } = this;
      const { left, top } = chart.cursor;
      const away = left == null || left < 0 || left > chart.over.clientWidth + 1;
      if (data.heat) return this.overFields(away, left, top);
      if (this.isPlane) return this.overPlane(away, left, top);
      const x = away ? null : chart.posToVal(left, "x");
      this.at.textContent = away ? "" : `${data.x.replace(/ *\[.*\]$/, "")} ${number(x)}`;
      for (const it of this.series) {
        if (it.style === "area") continue;
        const point = away || !it.shown ? null : this.point(it, x);
        it.value.textContent = point ? number(point[1]) : "";
        this.mark(it, point && it.style !== "bound" ? point[0] : null, point?.[1]);
      }
      this.figure.dispatchEvent(new CustomEvent("instant", { bubbles: true, detail: { x, quantity: data.x } }));
    }

    // The point of a series at the cursor: the nearest one, or on the line between two that are far apart.
    point({ x, y }, value) {
      const near = nearest(x, value);
      const px = (it) => this.chart.valToPos(it, "x");
      if (near == null || Math.abs(px(x[near]) - px(value)) < 6) return near == null ? null : [x[near], y[near]];
      const k = place(x, value);
      if (k === 0 || k === x.length) return [x[near], y[near]];
      return [value, y[k - 1] + (y[k] - y[k - 1]) * (value - x[k - 1]) / (x[k] - x[k - 1])];
    }

    overPlane(away, left, top) {
      let best = null;
      if (!away) {
        for (const it of this.series) {
          if (!it.shown || it.style === "area" || it.style === "grid") continue;
          for (let k = 0; k < it.x.length; k += 1) {
            const far = Math.hypot(this.chart.valToPos(it.x[k], "x") - left, this.chart.valToPos(it.y[k], "y") - top);
            // Of points in one place that with a value beside it says more.
            if (far < (best ? best.far : NEAR)) best = { it, k, far };
          }
        }
      }
      for (const it of this.series) this.mark(it, best?.it === it ? it.x[best.k] : null, best ? it.y[best.k] : null);
      if (!best) { this.at.textContent = ""; return; }
      const { it, k } = best;
      const place = this.data.equal ? complex(it.x[k], it.y[k]) : `${number(it.x[k])}, ${number(it.y[k])}`;
      this.at.textContent = `${it.name}: ${place}${it.at ? `, ${it.at.name} ${number(it.at.values[k])}` : ""}`;
    }

    overFields(away, left, top) {
      const { data } = this;
      const [c, r] = away ? [-1, -1] : [Math.round(this.chart.posToVal(left, "x")), Math.round(this.chart.posToVal(top, "y"))];
      this.at.textContent = data.heat[r]?.[c] === undefined ? "" : this.field(r, c);
    }

    // A field in words.
    field(row, column) {
      const { data } = this;
      return `${number(data.heat[row][column])} at ${data.x} ${data.columns[column]}, ${data.y} ${data.rows[row]}`;
    }

    // The arrow keys move the cursor: over a heat map by a field, else by a hundredth of the plot, with Shift by a tenth.
    key(event) {
      const { chart, data } = this;
      const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (event.key === "Escape") this.leave();
      if (!by || (by[1] && !this.isPlane && !data.heat)) return;
      event.preventDefault();
      const size = [chart.over.clientWidth, chart.over.clientHeight];
      const count = data.heat ? [data.columns.length, data.rows.length] : [0, 0].map(() => (event.shiftKey ? 10 : 100));
      const now = [chart.cursor.left, chart.cursor.top];
      const [left, top] = size.map((whole, k) => {
        const step = whole / count[k];
        const next = (now[0] >= 0 ? now[k] : whole / 2) + by[k] * step;
        return Math.min(whole - (data.heat ? step / 2 : 0), Math.max(data.heat ? step / 2 : 0, next));
      });
      chart.setCursor({ left, top }, true, true);
    }

    leave() { this.chart.setCursor({ left: -10, top: -10 }, true, true); }

    // What the plot shows, in words, for those who do not see it.
    words() {
      const { data } = this;
      if (data.heat) return `${data.quantity} over ${data.x} and ${data.y}, from ${data.range.map((it) => number(it)).join(" to ")}`;
      const named = this.series.filter((it) => it.name && it.y.length);
      const each = named.slice(0, 8).map((it) => `${it.name} from ${bounds([it.y]).map((y) => number(y)).join(" to ")}`);
      return `${data.y} over ${data.x}: ${each.join("; ")}${named.length > 8 ? `; ${named.length - 8} more` : ""}`;
    }

    // The points as drawn.
    csv() {
      const { data } = this;
      const quoted = (it) => (/[",\n]/.test(String(it)) ? `"${String(it).replaceAll('"', '""')}"` : String(it ?? ""));
      const rows = data.heat
        ? [[data.x, data.y, data.quantity], ...data.heat.flatMap((row, r) => row.map((value, c) => [data.columns[c], data.rows[r], value]))]
        : [["series", data.x, data.y, "value"], ...this.series.filter((it) => it.style !== "grid").flatMap((it) => it.x.map((x, k) => [it.name, x, it.y[k], it.at?.values[k]]))];
      return rows.map((row) => row.map(quoted).join(",")).join("\n") + "\n";
    }
  }

  function nearest(x, value) {
    const k = place(x, value);
    const best = k > 0 && (k === x.length || value - x[k - 1] < x[k] - value) ? k - 1 : k;
    const span = x[x.length - 1] - x[0];
    return x.length && value >= x[0] - 0.02 * span && value <= x[x.length - 1] + 0.02 * span ? best : null;
  }

  const complex = (re, im) => (im === 0 ? number(re) : `${number(re)} ${im < 0 ? "−" : "+"} ${number(Math.abs(im))}i`);

  // How a series is drawn, for the legend.
  function mark(series) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("width", "18");
    svg.setAttribute("height", "12");
    svg.setAttribute("aria-hidden", "true");
    const shape = document.createElementNS(svg.namespaceURI, "path");
    const shapes = {
      crosses: "M5 2l8 8M5 10l8-8", circles: "M14 6a5 5 0 1 1-10 0a5 5 0 1 1 10 0", squares: "M5 2h8v8h-8z", diamonds: "M9 1l5 5l-5 5l-5-5z", dots: "M10.5 6a1.5 1.5 0 1 1-3 0a1.5 1.5 0 1 1 3 0",
      area: "M1 1h16v10H1z",
    };
    shape.setAttribute("d", shapes[series.style] ?? "M0 6h18");
    const colour = series.colour ? `var(--series-${(series.colour - 1) % 8 + 1})` : "var(--text)";
    const style = series.style;
    shape.style.fill = style === "area" || style === "dots" ? colour : "none";
    shape.style.stroke = style === "area" ? "none" : colour;
    shape.style.strokeWidth = style === "broad" ? "5" : "2";
    shape.style.opacity = style === "area" ? "0.3" : style === "broad" ? "0.5" : "1";
    if (style === "dashed" || style === "bound" || series.colour > 8) shape.style.strokeDasharray = "5 3";
    svg.append(shape);
    return svg;
  }

  function save(name, url) {
    const link = make("a");
    link.href = url;
    link.download = name;
    link.click();
  }

  function tools(figure, drawing) {
    const heading = figure.querySelector("h2").textContent;
    const name = heading.replace(/[^\w.-]+/g, "_").slice(0, 60) || "plot";
    const tool = (text, title, work) => {
      const it = make("button", "", text);
      it.type = "button";
      it.title = title;
      it.setAttribute("aria-label", `${text}: ${title} of ${heading}`);
      it.addEventListener("click", work);
      figure.querySelector(".head").append(it);
    };
    tool("PNG", "save the picture", () => save(`${name}.png`, drawing.chart.ctx.canvas.toDataURL("image/png")));
    tool("CSV", "save the points", () => {
      const url = URL.createObjectURL(new Blob([drawing.csv()], { type: "text/csv" }));
      save(`${name}.csv`, url);
      setTimeout(() => URL.revokeObjectURL(url), 1000);
    });
  }

  function draw(figure) {
    if (figure.dataset.drawn) return;
    figure.dataset.drawn = "yes";
    const drawing = new Drawing(figure);
    drawings.push(drawing);
    const { link } = drawing.data;
    if (link) groups.set(link, [...(groups.get(link) ?? []), drawing]);
    tools(figure, drawing);
  }

  document.querySelector("header").append(theme.button());
  theme.onChange(() => drawings.forEach((it) => it.chart.redraw(false)));

  // What scrolls within the page can be reached by keyboard, and has a name: that of the heading, or of the part that is opened, before it.
  const headings = [...document.querySelectorAll("h1, h2, h3, summary")];
  const named = (area) => headings.findLast((it) => it.compareDocumentPosition(area) & Node.DOCUMENT_POSITION_FOLLOWING);
  const scrolls = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      if (target.scrollWidth > target.clientWidth || target.scrollHeight > target.clientHeight) target.tabIndex = 0;
      else target.removeAttribute("tabindex");
    }
  });
  for (const area of document.querySelectorAll(".scroll, pre")) {
    area.setAttribute("role", "group");
    area.setAttribute("aria-label", `${named(area)?.textContent ?? ""}: ${area.matches("pre") ? "text" : "table"}`);
    scrolls.observe(area);
  }

  // A plot is drawn when it comes near the window; all of them for the printer.
  const figures = [...document.querySelectorAll("figure.plot:has(script)")];
  for (const figure of figures) figure.setAttribute("aria-label", figure.querySelector("h2").textContent);
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting) {
        watcher.unobserve(entry.target);
        draw(entry.target);
      }
    }
  }, { rootMargin: "600px" });
  for (const figure of figures) {
    if (figure.getBoundingClientRect().top < innerHeight) draw(figure); else watcher.observe(figure);
  }

  // A link to a plot may name a range of its x axis, which is shaded there.
  addEventListener("click", (event) => {
    const link = event.target.closest?.("a[data-from]");
    const figure = link && document.getElementById(link.hash.slice(1))?.querySelector("figure.plot:has(script)");
    if (!figure) return;
    draw(figure);
    for (const it of drawings) {
      it.range = it.figure === figure ? [Number(link.dataset.from), Number(link.dataset.to)] : null;
      it.chart.redraw(false);
    }
  });

  // px; a page may print its plots narrower.
  const PAPER = Number(document.querySelector("[data-paper]")?.dataset.paper ?? 640);
  let before = null;
  addEventListener("beforeprint", () => {
    before = theme.isSet();
    theme.set("light");
    figures.forEach(draw);
    drawings.forEach((it) => it.fit(PAPER));
  });
  addEventListener("afterprint", () => {
    theme.set(before ?? "auto");
    drawings.forEach((it) => it.fit());
  });
})();
