"use strict";
// The page's own script: draws the plots by uPlot, lets all of them follow a zoom, and sorts the table of runs.
(() => {
  const LIGHT = { ink: "#1c2024", soft: "#5b6570", line: "#e4e7ea", tones: 42,
    colors: ["#0b62a8", "#c2410c", "#1d7a45", "#8b3fb0", "#a16207", "#d6409f", "#0891a8", "#57606a"] };
  const DARK = { ink: "#e6e8ea", soft: "#9aa4ae", line: "#2b3136", tones: 64,
    colors: ["#6cb4f2", "#ff9a62", "#5fcf8d", "#cf9bf0", "#e8c14a", "#ff8fc0", "#5bd0e0", "#b5bec7"] };
  const page = JSON.parse(document.getElementById("data").textContent);
  // The runs of a sweep, by whose names the curves of all plots go: what they are colored by, and those that are shown alone.
  const runs = page.runs || null;
  let key = 0;
  let lit = null;
  let pinned = null;
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let isPrinting = false;
  const theme = () => (dark.matches && !isPrinting ? DARK : LIGHT);
  const plots = [];
  let isReady = false;

  // The color of one of n: of few, one that is told from the others; of many, one by its place among them.
  const color = (k, n) => {
    const { colors, tones } = theme();
    return n <= colors.length ? colors[k] : `hsl(${Math.round(265 - (245 * k) / (n - 1))} 65% ${tones}%)`;
  };
  // The values that the runs have of a key, in order.
  const valuesOf = (k) => [...new Set(runs.values.map((row) => row[k]))].sort((a, b) => a.localeCompare(b, undefined, { numeric: true }))
    .sort((a, b) => Number(a) - Number(b) || 0);
  // The color of a run: its own where the runs are few, else that of its value, from the least to the greatest.
  const runColor = (run) => {
    if (runs.labels.length <= theme().colors.length) return color(run, runs.labels.length);
    const values = valuesOf(key);
    const { tones } = theme();
    return `hsl(${Math.round(265 - (245 * values.indexOf(runs.values[run][key])) / Math.max(1, values.length - 1))} 65% ${tones}%)`;
  };
  let runColors = null;
  const stroke = (label, k, n) => {
    if (!runs) return color(k, n);
    if (!runColors) runColors = runs.labels.map((_, run) => runColor(run));
    const run = runs.labels.indexOf(label);
    // Those beside are so faint that what they are drawn over is seen.
    return lit && !lit.has(run) ? `${theme().soft}22` : runColors[run] || theme().soft;
  };

  const minus = (text) => text.replace(/-/g, "−");
  const number = (v) => {
    if (v == null) return "–";
    const size = Math.abs(v);
    return minus(size !== 0 && (size < 1e-3 || size >= 1e6) ? v.toExponential(3) : String(+v.toPrecision(5)));
  };
  const tick = (v, step) => {
    if (v == null) return "";
    if (v === 0) return "0";
    const size = Math.max(Math.abs(v), step);
    if (size < 1e-3 || size >= 1e5) return minus(v.toExponential(6).replace(/\.?0*e\+?/, "e"));
    // As many decimals as the step has: 0.25 has two.
    let decimals = Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    if (Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6) decimals += 1;
    return minus(v.toFixed(decimals));
  };
  const ticks = (u, splits, axis, space, step) => splits.map((v) => tick(v, step || 1));
  const powers = (u, splits) => splits.map((v) => (v == null ? "" : minus(v.toExponential(0)).replace("+", "")));
  // Lines of a logarithmic axis: powers of ten at equal distances, at most seven, and of a decade or two what is between them.
  const decades = (u, axis, min, max) => {
    const [from, to] = [Math.ceil(Math.log10(min) - 1e-9), Math.floor(Math.log10(max) + 1e-9)];
    const between = to - from < 2 ? [1, 2, 5] : [1];
    const by = Math.max(1, Math.ceil((to - from) / 6));
    const lines = [];
    for (let e = from - 1; e <= to; e++) {
      if ((e - from) % by === 0) between.forEach((m) => lines.push(m * 10 ** e));
    }
    return lines.filter((v) => v >= min * 0.999 && v <= max * 1.001);
  };
  const width = (u, values) => 14 + 7 * Math.max(3, ...(values || []).map((v) => v.length));

  // The nearest instant at which a curve has a value: curves of several runs have their own times.
  const nearest = (u, series, at) => {
    const values = u.data[series];
    if (values[at] !== undefined) return at;
    for (let d = 1; d < values.length; d++) {
      if (values[at - d] !== undefined && at - d >= 0) return at - d;
      if (values[at + d] !== undefined) return at + d;
    }
    return at;
  };

  // Two fingers zoom: what was between them stays between them.
  const pinch = (u) => {
    let start = null;
    const places = (e) => [...e.touches].map((t) => t.clientX - u.over.getBoundingClientRect().left).sort((a, b) => a - b);
    u.over.addEventListener("touchstart", (e) => {
      if (e.touches.length !== 2) return;
      const [a, b] = places(e);
      if (b - a > 10) start = [u.posToVal(a, "x"), u.posToVal(b, "x")];
    }, { passive: true });
    u.over.addEventListener("touchmove", (e) => {
      if (!start || e.touches.length !== 2) return;
      e.preventDefault();
      const [a, b] = places(e);
      if (b - a < 10) return;
      const scale = (start[1] - start[0]) / (b - a);
      const min = start[0] - a * scale;
      zoom(u, Math.max(u.whole[0], min), Math.min(u.whole[1], min + scale * u.over.clientWidth));
    }, { passive: false });
    u.over.addEventListener("touchend", () => { start = null; });
  };

  const zoom = (u, min, max) => {
    if (max > min && (u.scales.x.min !== min || u.scales.x.max !== max)) u.setScale("x", { min, max });
  };
  const follow = (u, key) => {
    if (!isReady || key !== "x") return;
    const { min, max } = u.scales.x;
    const isWhole = min === u.whole[0] && max === u.whole[1];
    for (const other of plots) {
      if (other === u) continue;
      if (isWhole) zoom(other, other.whole[0], other.whole[1]);
      else if (min < other.whole[1] && max > other.whole[0]) zoom(other, min, max);
    }
  };

  const axis = (more) => ({
    stroke: () => theme().soft, font: "11px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 20,
    grid: { stroke: () => theme().line, width: 1 }, ticks: { stroke: () => theme().line, width: 1, size: 5 }, ...more,
  });

  const build = (figure, spec) => {
    const n = spec.labels.length;
    const data = spec.tables.length > 1 ? uPlot.join(spec.tables) : spec.tables[0];
    if (!data || data[0].length === 0) {
      figure.append(Object.assign(document.createElement("p"), { className: "small", textContent: "no values" }));
      return null;
    }
    const isLone = data[0].length === 1;
    const near = Object.assign(document.createElement("div"), { className: "near" });
    // The runs of a sweep have one legend for all plots.
    const hasLegend = !runs && n <= 12;
    const series = spec.labels.map((label, k) => ({
      label, stroke: () => stroke(label, k, n), width: n > 12 ? 1.2 : 1.5, value: (u, v) => number(v), pxAlign: 0,
      points: isLone ? { show: true } : { show: false },
    }));
    const say = (u, k) => {
      if (hasLegend) return;
      const at = u.cursor.idxs && k != null ? u.cursor.idxs[k] : null;
      near.textContent = at == null ? "" : `${spec.labels[k - 1]}: ${number(u.data[k][at])} at ${number(u.data[0][at])} s`;
    };
    const times = data[0];
    const [first, last] = [times[0], times[times.length - 1]];
    const whole = first === last ? [first - 0.5, first + 0.5] : [first, last];
    // The vertical range of the whole time may leave out a first instant that would flatten the rest; the caption says so.
    // The range of times is asked for before the vertical one, and stands in the scales only after both.
    let shown = whole;
    const isWhole = () => shown[0] === whole[0] && shown[1] === whole[1];
    // What does not change, but for noise, is a line in the middle.
    const room = (min, max) => {
      if (min == null) return [0, 1];
      const [middle, span] = [(min + max) / 2, Math.max(1e-12 * Math.max(Math.abs(min), Math.abs(max)), spec.span || 0)];
      if (max - min > span) return uPlot.rangeNum(min, max, 0.08, true);
      const half = Math.max(0.5 * Math.abs(middle), 1e10 * (spec.span || 0)) || 1;
      return [middle - half, middle + half];
    };
    let isFull = false;
    const vertical = spec.log ? { distr: 3 } : { range: (u, min, max) => (spec.range && !isFull && isWhole() ? spec.range : room(min, max)) };
    const u = new uPlot({
      width: figure.clientWidth, height: height(figure),
      scales: { x: { time: false, range: (u, min, max) => (shown = isLone || min == null ? whole : [min, max]) }, y: vertical },
      series: [{ label: "time [s]", value: (u, v) => number(v) }, ...series],
      axes: [
        axis({ label: "time [s]", values: ticks, size: 32 }),
        axis({ label: spec.axis || undefined, values: spec.log ? powers : ticks, size: width,
          ...(spec.log ? { splits: decades, filter: (u, splits) => splits } : {}) }),
      ],
      legend: { show: hasLegend },
      cursor: { dataIdx: nearest, drag: { x: true, y: false, dist: 6 }, focus: { prox: hasLegend ? -1 : 24 }, y: false },
      focus: { alpha: hasLegend ? 1 : 0.25 },
      hooks: { setScale: [follow], setSeries: [say], ready: [pinch] },
    }, data, figure);
    u.whole = whole;
    const full = figure.querySelector(".full");
    if (full) full.addEventListener("click", () => {
      isFull = !isFull;
      full.setAttribute("aria-pressed", String(isFull));
      full.textContent = isFull ? "leave out again" : "show all";
      u.setScale("x", { min: u.scales.x.min, max: u.scales.x.max });
    });
    if (!hasLegend) figure.append(near);
    return u;
  };
  const height = (figure) => Math.round(Math.min(300, Math.max(210, figure.clientWidth * 0.5)));

  const draw = () => {
    const specs = page.plots;
    const figures = [...document.querySelectorAll(".plot")];
    for (const figure of figures) {
      const u = build(figure, specs[Number(figure.dataset.plot)]);
      if (!u) continue;
      plots.push(u);
      new ResizeObserver(() => {
        requestAnimationFrame(() => {
          if (figure.clientWidth > 0 && figure.clientWidth !== u.width) u.setSize({ width: figure.clientWidth, height: height(figure) });
        });
      }).observe(figure);
    }
    document.documentElement.dataset.plots = `${plots.length} of ${figures.length}`;
    setTimeout(() => { isReady = true; }, 0);
    const redraw = () => { runColors = null; plots.forEach((u) => u.redraw(false, true)); };
    if (document.getElementById("legend")) legend(redraw);
    dark.addEventListener("change", redraw);
    addEventListener("beforeprint", () => { isPrinting = true; redraw(); });
    addEventListener("afterprint", () => { isPrinting = false; redraw(); });
    const reset = document.getElementById("reset");
    if (reset) reset.addEventListener("click", () => plots.forEach((u) => zoom(u, u.whole[0], u.whole[1])));
  };

  // The legend of a sweep: its runs, or where they are many the values of one key. What is pointed at is shown alone, a click keeps it.
  const legend = (redraw) => {
    const place = document.getElementById("legend");
    const list = document.createElement("ul");
    const isByRun = runs.labels.length <= theme().colors.length;
    const show = (some) => { lit = some || pinned; redraw(); };
    const entry = (name, those) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.style.setProperty("--swatch", runColor(those[0]));
      const some = new Set(those);
      button.addEventListener("mouseenter", () => show(some));
      button.addEventListener("mouseleave", () => show(null));
      button.addEventListener("click", () => {
        const isOn = button.getAttribute("aria-pressed") !== "true";
        list.querySelectorAll("button").forEach((other) => other.setAttribute("aria-pressed", "false"));
        button.setAttribute("aria-pressed", String(isOn));
        pinned = isOn ? some : null;
        show(null);
      });
      const item = document.createElement("li");
      item.append(button);
      list.append(item);
    };
    const fill = () => {
      list.replaceChildren();
      [pinned, lit] = [null, null];
      if (isByRun) runs.labels.forEach((label, run) => entry(label, [run]));
      else for (const value of valuesOf(key)) entry(value, runs.values.flatMap((row, run) => (row[key] === value ? [run] : [])));
    };
    if (!isByRun) {
      const label = Object.assign(document.createElement("label"), { textContent: "Colored by " });
      const select = document.createElement("select");
      runs.keys.forEach((name, k) => select.append(new Option(name, k)));
      select.addEventListener("change", () => { key = Number(select.value); fill(); redraw(); });
      label.append(select);
      place.append(label);
    }
    fill();
    place.append(list);
    dark.addEventListener("change", () => { fill(); });
  };

  // Rows are sorted by the numbers of a column where all have one, else by its texts; a second click turns the order round.
  const sortable = (table) => {
    const heads = [...table.querySelectorAll("th")];
    heads.forEach((head, k) => head.addEventListener("click", () => {
      const isDown = head.getAttribute("aria-sort") === "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", isDown ? "descending" : "ascending");
      const body = table.tBodies[0];
      const rows = [...body.rows].map((row) => ({ row, text: row.cells[k].textContent, value: row.cells[k].dataset.value }));
      const compare = (a, b) => {
        if (a.value === undefined || b.value === undefined) {
          if (a.value !== undefined || b.value !== undefined) return a.value === undefined ? 1 : -1;
          return (isDown ? -1 : 1) * a.text.localeCompare(b.text, undefined, { numeric: true });
        }
        return (isDown ? -1 : 1) * (Number(a.value) - Number(b.value));
      };
      rows.sort(compare).forEach(({ row }) => body.append(row));
    }));
  };

  document.querySelectorAll("table.sortable").forEach(sortable);
  draw();
})();
