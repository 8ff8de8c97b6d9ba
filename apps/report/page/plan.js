"use strict";
// Places in the world seen along an axis, at one scale: the way of the camera, and the graph of
// keyframes.
(function () {
  const { html, svg, number, ticks, tickLabel, extent } = Highwall;
  const kWidth = 560, kHeight = 400, kLeft = 62, kTop = 12, kBottom = 42, kBar = 84;
  const kLevels = 40;

  // Axes of the world: from above, and from the side that shows more of it.
  Highwall.viewsOf = function (positions) {
    const width = (k) => { const [a, b] = extent(positions.map((p) => p[k])); return b - a; };
    const along = width(0) >= width(1) ? 0 : 1;
    return { top: [0, 1], side: [along, 2] };
  };

  // Maps a position to the drawing; metres are equally long in both directions.
  function projection(positions, [h, v], box) {
    const ranges = [h, v].map((k) => extent(positions.map((p) => p[k])));
    const size = ranges.map(([a, b]) => Math.max(b - a, 1e-3) * 1.1);
    const scale = Math.min(box.width / size[0], box.height / size[1]);
    const middle = ranges.map(([a, b]) => (a + b) / 2);
    const x = (value) => box.left + box.width / 2 + scale * (value - middle[0]);
    const y = (value) => box.top + box.height / 2 - scale * (value - middle[1]);
    return {
      x, y, at: (p) => x(p[h]).toFixed(1) + " " + y(p[v]).toFixed(1),
      xRange: [middle[0] - box.width / 2 / scale, middle[0] + box.width / 2 / scale],
      yRange: [middle[1] - box.height / 2 / scale, middle[1] + box.height / 2 / scale],
    };
  }

  function drawFrame(plot, box, map, [h, v]) {
    for (const value of ticks(map.xRange, 6)) {
      plot.append(svg("path", { class: "grid", d: `M${map.x(value)} ${box.top}v${box.height}` }),
        svg("text", { x: map.x(value), y: box.top + box.height + 18, "text-anchor": "middle" }, tickLabel(value, ticks(map.xRange, 6))));
    }
    for (const value of ticks(map.yRange, 6)) {
      plot.append(svg("path", { class: "grid", d: `M${box.left} ${map.y(value)}h${box.width}` }),
        svg("text", { x: box.left - 8, y: map.y(value) + 4, "text-anchor": "end" }, tickLabel(value, ticks(map.yRange, 6))));
    }
    plot.append(svg("path", { class: "axis", d: `M${box.left} ${box.top}v${box.height}h${box.width}` }),
      svg("text", { x: box.left + box.width / 2, y: box.top + box.height + 36, "text-anchor": "middle" }, "xyz"[h] + " [m]"));
    const middle = box.top + box.height / 2;
    plot.append(svg("text", { x: 13, y: middle, "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` }, "xyz"[v] + " [m]"));
  }

  // t: seconds of each position; where frames are missing the line is interrupted.
  function polyline(positions, map, t) {
    const gap = t ? Highwall.gapOf(t) : Infinity;
    return positions.map((p, i) => (i > 0 && !(t && t[i] - t[i - 1] > gap) ? "L" : "M") + map.at(p)).join("");
  }

  // One path for each stretch of one colour.
  function drawColoured(plot, positions, t, values, range, colour, map) {
    const gap = Highwall.gapOf(t);
    plot.append(svg("path", { class: "curve casing", "stroke-width": 4.6, style: "stroke-width:4.6", d: polyline(positions, map, t) }));
    const level = (v) => v === null || v === undefined ? -1
      : Math.min(kLevels - 1, Math.floor(kLevels * Math.max(0, (v - range[0]) / (range[1] - range[0]))));
    let from = 0;
    for (let i = 1; i <= positions.length; ++i) {
      const leaps = i < positions.length && t[i] - t[i - 1] > gap;
      if (i < positions.length && !leaps && level(values[i]) === level(values[from])) continue;
      const stroke = level(values[from]) < 0 ? "var(--truth)" : Highwall.css(colour((level(values[from]) + 0.5) / kLevels));
      plot.append(svg("path", { class: "curve", style: `stroke:${stroke};stroke-width:3`, d: polyline(positions.slice(from, leaps ? i : Math.min(i + 1, positions.length)), map) }));
      from = i;
    }
  }

  function drawColourBar(plot, range, colour, label, box) {
    const left = box.left + box.width + 18, steps = 48;
    for (let i = 0; i < steps; ++i) {
      plot.append(svg("rect", { x: left, y: box.top + box.height * (1 - (i + 1) / steps), width: 13,
        height: box.height / steps + (i > 0 ? 0.7 : 0), fill: Highwall.css(colour((i + 0.5) / steps)) }));
    }
    const marks = ticks(range, 5);
    for (const value of marks) {
      const y = box.top + box.height * (1 - (value - range[0]) / (range[1] - range[0]));
      plot.append(svg("text", { x: left + 19, y: y + 4 }, tickLabel(value, marks)));
    }
    const middle = box.top + box.height / 2;
    plot.append(svg("text", { x: left + 62, y: middle, "text-anchor": "middle", transform: `rotate(-90 ${left + 62} ${middle})` }, label));
  }

  // options: title, axes [h, v], extentOf (positions that must fit), truth, path with t [s] and
  // values, range, colour, label.
  Highwall.pathPlan = function (options) {
    const box = { left: kLeft, top: kTop, width: kWidth - kLeft - kBar, height: kHeight - kTop - kBottom };
    const map = projection(options.extentOf, options.axes, box);
    const plot = svg("svg", { viewBox: `0 0 ${kWidth} ${kHeight}`, role: "img", "aria-label":
      `${options.title}, coloured by ${options.label}, from ${number(options.range[0], 3)} to ${number(options.range[1], 3)}` });
    drawFrame(plot, box, map, options.axes);
    if (options.truth) plot.append(svg("path", { class: "curve truth", d: polyline(options.truth, map) }));
    drawColoured(plot, options.path, options.t, options.values, options.range, options.colour, map);
    drawColourBar(plot, options.range, options.colour, options.label, box);
    const first = options.path[0];
    plot.append(svg("circle", { class: "node", cx: map.x(first[options.axes[0]]), cy: map.y(first[options.axes[1]]), r: 4.5 }),
      svg("text", { class: "label", x: map.x(first[options.axes[0]]) + 8, y: map.y(first[options.axes[1]]) - 7 }, "start"));
    return html("figure", {}, html("figcaption", {}, options.title),
      options.truth ? Highwall.legend([{ name: "ground truth", style: "truth" }, { name: "estimate, coloured by " + options.label, style: "scale" }]) : null,
      plot);
  };

  // Keyframes, whom they share landmarks with, and loops. options: title, axes, extentOf, graph,
  // loops, level (turns positions).
  Highwall.graphPlan = function (options) {
    const box = { left: kLeft, top: kTop, width: kWidth - kLeft - 14, height: kHeight - kTop - kBottom };
    const places = options.graph.keyframes.map((k) => options.level(k.position));
    const map = projection(options.extentOf, options.axes, box);
    const edge = (a, b) => `M${map.at(a)}L${map.at(b)}`;
    const closed = options.loops.filter((l) => l.result !== "refused"), refused = options.loops.filter((l) => l.result === "refused");
    const plot = svg("svg", { viewBox: `0 0 ${kWidth} ${kHeight}`, role: "img", "aria-label":
      `${options.title}: ${places.length} keyframes, ${closed.length} loops closed, ${refused.length} refused` });
    drawFrame(plot, box, map, options.axes);
    plot.append(svg("path", { class: "shared", d: options.graph.covisible.map(([a, b]) => edge(places[a], places[b])).join("") }));
    for (const [loops, style] of [[refused, "refused"], [closed, "loop"]]) {
      const drawn = loops.filter((l) => l.from && l.to);
      plot.append(svg("path", { class: style, d: drawn.map((l) => edge(options.level(l.from), options.level(l.to))).join("") }));
    }
    for (const place of places) plot.append(svg("circle", { class: "node", cx: map.x(place[options.axes[0]]), cy: map.y(place[options.axes[1]]), r: 2.6 }));
    const legend = [{ name: "keyframe", style: "node" }, { name: "shares landmarks", style: "shared" }];
    if (closed.length) legend.push({ name: "loop closed", style: "loop" });
    if (refused.length) legend.push({ name: "loop refused", style: "refused" });
    return html("figure", {}, html("figcaption", {}, options.title), Highwall.legend(legend), plot);
  };

  // Milliseconds of each stage as bars: median, up to the mean, up to 95 of 100.
  Highwall.stageBars = function (title, stages, most) {
    const row = 30, left = 190, width = 560, right = 74, height = stages.length * row + 44;
    const plot = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": title + ": " +
      stages.map((s) => `${s.name} ${number(s.median, 3)} ms, 95 % within ${number(s.p95, 3)} ms`).join("; ") });
    const marks = ticks([0, most], 6);
    const x = (ms) => left + (ms / most) * (width - left - right);
    for (const ms of marks) {
      plot.append(svg("path", { class: "grid", d: `M${x(ms)} 4V${stages.length * row + 6}` }),
        svg("text", { x: x(ms), y: stages.length * row + 22, "text-anchor": "middle" }, tickLabel(ms, marks)));
    }
    plot.append(svg("text", { x: (left + width - right) / 2, y: stages.length * row + 39, "text-anchor": "middle" }, "milliseconds"));
    stages.forEach((stage, i) => {
      const y = 8 + i * row;
      plot.append(svg("text", { class: "label", x: left - 10, y: y + 15, "text-anchor": "end" }, stage.name),
        svg("rect", { class: "fill0", "fill-opacity": 0.28, x: left, y: y + 3, width: Math.max(0, x(Math.min(stage.p95, most)) - left), height: 16, rx: 2 }),
        svg("rect", { class: "fill0", x: left, y: y + 3, width: Math.max(0, x(Math.min(stage.median, most)) - left), height: 16, rx: 2 }),
        svg("text", { x: x(Math.min(stage.p95, most)) + 6, y: y + 15 }, `${number(stage.median, 3)} / ${number(stage.p95, 3)}`));
    });
    return html("figure", {}, html("figcaption", {}, title, html("small", {}, "full: median, pale: 95 of 100")), plot);
  };

  // When each map was tracked, and when none was.
  Highwall.timeline = function (title, maps, lost, xRange) {
    const row = 26, left = 62, width = 1140, rows = maps.length + (lost.length ? 1 : 0), height = rows * row + 46;
    const x = (t) => left + ((t - xRange[0]) / (xRange[1] - xRange[0])) * (width - left - 14);
    const plot = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${title}: ${maps.length} maps, ${lost.length} frames without a pose` });
    const marks = ticks(xRange, 12);
    for (const t of marks) {
      plot.append(svg("path", { class: "grid", d: `M${x(t)} 2V${rows * row + 4}` }),
        svg("text", { x: x(t), y: rows * row + 20, "text-anchor": "middle" }, tickLabel(t, marks)));
    }
    plot.append(svg("text", { x: (left + width) / 2, y: rows * row + 38, "text-anchor": "middle" }, "time [s]"));
    maps.forEach((one, i) => {
      plot.append(svg("text", { class: "label", x: left - 10, y: i * row + 19, "text-anchor": "end" }, `map ${i + 1}`));
      for (const [from, to] of one.spans) {
        plot.append(svg("rect", { class: "fill" + (i % 6), x: x(from), y: i * row + 6, width: Math.max(2, x(to) - x(from)), height: 16, rx: 3 }));
      }
    });
    if (lost.length) {
      plot.append(svg("text", { class: "label", x: left - 10, y: maps.length * row + 19, "text-anchor": "end" }, "lost"));
      for (const { t } of lost) plot.append(svg("rect", { class: "fill1", x: x(t) - 0.8, y: maps.length * row + 6, width: 1.6, height: 16 }));
    }
    return html("figure", {}, html("figcaption", {}, title), plot);
  };
})();
