"use strict";
// Curves over time, as SVG: with a cross hair that follows the mouse and the arrow keys.
(function () {
  const { html, svg, number, ticks, tickLabel, extent } = Highwall;
  const kLeft = 70, kRight = 14, kTop = 10, kBottom = 40;

  // Log scales draw powers of ten.
  function axis(range, low, high, logarithmic) {
    const f = logarithmic ? Math.log10 : (v) => v;
    const a = f(range[0]), b = f(range[1]);
    return (value) => low + ((f(value) - a) / (b - a)) * (high - low);
  }

  // Powers of ten, and between few of them their double and fivefold.
  function decades([low, high]) {
    const values = [], steps = high / low < 1e3 ? [1, 2, 5] : [1];
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); ++e) {
      for (const step of steps) values.push(step * Math.pow(10, e));
    }
    return values.filter((v) => v >= low && v <= high);
  }

  function widened([low, high], fromZero) {
    if (!isFinite(low)) return [0, 1];
    if (fromZero && low >= 0) low = 0;
    if (high - low < 1e-12) return [low - (fromZero ? 0 : 0.5 * (Math.abs(low) || 1)), high + 0.5 * (Math.abs(high) || 1)];
    const margin = 0.06 * (high - low);
    return [fromZero && low === 0 ? 0 : low - margin, high + margin];
  }

  // The range that several charts share, so that they can be compared.
  Highwall.sharedRange = function (lists, { fromZero = true, logarithmic = false, level } = {}) {
    const range = [Infinity, -Infinity];
    for (const list of lists) extent(logarithmic ? list.filter((v) => v > 0) : list, range);
    if (!logarithmic) return widened(range, fromZero);
    if (!isFinite(range[0])) return [0.1, 10];
    if (level !== undefined) extent([level], range);
    return [range[0] / 1.3, range[1] * 1.3];
  };

  // A path that is interrupted where there is no value, and where time leaps.
  function pathOf(x, y, mapX, mapY, logarithmic, gap) {
    let d = "", pen = false, last = 0;
    for (let i = 0; i < x.length; ++i) {
      const value = y[i];
      const drawn = typeof value === "number" && isFinite(value) && (!logarithmic || value > 0);
      if (!drawn) { pen = false; continue; }
      if (pen && x[i] - last > gap) pen = false;
      d += (pen ? "L" : "M") + mapX(x[i]).toFixed(1) + " " + mapY(value).toFixed(1);
      if (!pen) d += "h0.01";
      pen = true;
      last = x[i];
    }
    return d;
  }

  function nearest(x, t) {
    let low = 0, high = x.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x[middle] < t) low = middle + 1; else high = middle;
    }
    return low > 0 && t - x[low - 1] < x[low] - t ? low - 1 : low;
  }

  function drawAxes(plot, box, xRange, yRange, mapX, mapY, options) {
    const yTicks = options.logarithmic ? decades(yRange) : ticks(yRange, box.height / 42);
    for (const value of yTicks) {
      const y = mapY(value);
      plot.append(svg("path", { class: "grid", d: `M${kLeft} ${y}H${kLeft + box.width}` }));
      const label = options.logarithmic ? String(+value.toPrecision(1)) : tickLabel(value, yTicks);
      plot.append(svg("text", { x: kLeft - 8, y: y + 4, "text-anchor": "end" }, label));
    }
    const xTicks = ticks(xRange, box.width / 90);
    for (const value of xTicks) {
      const x = mapX(value);
      plot.append(svg("path", { class: "axis", d: `M${x} ${kTop + box.height}v5` }));
      plot.append(svg("text", { x, y: kTop + box.height + 19, "text-anchor": "middle" }, tickLabel(value, xTicks)));
    }
    plot.append(svg("path", { class: "axis", d: `M${kLeft} ${kTop}V${kTop + box.height}H${kLeft + box.width}` }));
    plot.append(svg("text", { x: kLeft + box.width / 2, y: kTop + box.height + 36, "text-anchor": "middle" }, options.xLabel || "time [s]"));
    const middle = kTop + box.height / 2;
    plot.append(svg("text", { x: 13, y: middle, "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` }, options.yLabel));
  }

  function followPointer(plot, frame, series, box, xRange, mapX, readout, unit) {
    const cross = svg("path", { class: "cross", visibility: "hidden" });
    frame.append(cross);
    const longest = series.reduce((a, b) => (b.x.length > a.x.length ? b : a));
    let at = -1;
    function show(index) {
      at = Math.min(Math.max(index, 0), longest.x.length - 1);
      const t = longest.x[at];
      cross.setAttribute("d", `M${mapX(t)} ${kTop}v${box.height}`);
      cross.setAttribute("visibility", "visible");
      readout.textContent = `${t.toFixed(2)} s: ` + series
        .map((s) => (s.name ? s.name + " " : "") + number(s.y[nearest(s.x, t)], 4) + (unit ? " " + unit : "")).join(", ");
    }
    plot.addEventListener("pointermove", (event) => {
      const at = plot.getBoundingClientRect();
      const x = ((event.clientX - at.left) / at.width) * (kLeft + box.width + kRight);
      const share = (x - kLeft) / box.width;
      if (share >= -0.02 && share <= 1.02) show(nearest(longest.x, xRange[0] + share * (xRange[1] - xRange[0])));
    });
    plot.addEventListener("keydown", (event) => {
      const step = Math.max(1, Math.round(longest.x.length / 100));
      const moves = { ArrowLeft: -step, ArrowRight: step, Home: -Infinity, End: Infinity };
      if (!(event.key in moves)) return;
      event.preventDefault();
      show(Math.min(Math.max(at + moves[event.key], 0), longest.x.length - 1));
    });
  }

  // A sample of a line and what it stands for.
  Highwall.legend = function (entries) {
    return html("ul", { class: "legend" }, entries.map(({ name, style }) =>
      html("li", {}, svg("svg", { viewBox: "0 0 26 10", "aria-hidden": "true" },
        style === "band" ? svg("rect", { class: "band", width: 26, height: 10 })
          : style === "node" ? svg("circle", { class: "node", cx: 13, cy: 5, r: 3.2 })
          : svg("path", { class: "curve " + style, d: "M1 5H25" })), name)));
  };

  // options: title, note, yLabel, unit, series [{name, x, y, style}], xRange, yRange, bands [[from,
  // to]] with bandName, level (a line at a value) with levelName, logarithmic, width, height.
  Highwall.chart = function (options) {
    const series = options.series.filter((s) => s.x.length > 0);
    const width = options.width || 560, height = options.height || 230;
    const box = { width: width - kLeft - kRight, height: height - kTop - kBottom };
    const xRange = options.xRange || Highwall.sharedRange(series.map((s) => s.x), { fromZero: false });
    const yRange = options.yRange || Highwall.sharedRange(series.map((s) => s.y), options);
    const mapX = axis(xRange, kLeft, kLeft + box.width);
    const mapY = axis(yRange, kTop + box.height, kTop, options.logarithmic);
    const summary = series.map((s) => {
      const [low, high] = extent(s.y);
      return `${s.name || options.yLabel} from ${number(low, 3)} to ${number(high, 3)}`;
    }).join("; ");
    const plot = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", tabindex: "0",
      "aria-label": `${options.title}. ${summary}. Arrow keys read values.` });
    const frame = svg("g", {});
    plot.append(frame);
    for (const [from, to] of options.bands || []) {
      const left = mapX(from);
      frame.append(svg("rect", { class: "band", x: left, y: kTop, width: Math.max(1.5, mapX(to) - left), height: box.height }));
    }
    drawAxes(frame, box, xRange, yRange, mapX, mapY, options);
    if (options.level !== undefined) {
      frame.append(svg("path", { class: "curve s5 dash1", d: `M${kLeft} ${mapY(options.level)}h${box.width}` }));
    }
    for (const s of series) {
      frame.append(svg("path", { class: "curve " + s.style, d: pathOf(s.x, s.y, mapX, mapY, options.logarithmic, Highwall.gapOf(s.x)) }));
    }
    const readout = html("div", { class: "readout", "aria-live": "polite" });
    if (series.length) followPointer(plot, frame, series, box, xRange, mapX, readout, options.unit);
    const entries = series.filter((s) => s.name);
    if (options.level !== undefined && options.levelName) entries.push({ name: options.levelName, style: "s5 dash1" });
    if ((options.bands || []).length) entries.push({ name: options.bandName, style: "band" });
    return html("figure", {},
      html("figcaption", {}, options.title, options.note ? html("small", {}, "  " + options.note) : null),
      entries.length > 0 ? Highwall.legend(entries) : null, plot, readout);
  };
})();
