"use strict";
// The sections of the page: each takes the runs and gives an element, or null where there is
// nothing to show.
(function () {
  const { html, number, chart, sharedRange, get } = Highwall;
  const kSections = (Highwall.sections = []);

  // A section with a card for each run; `draw` gives null for a run without.
  function perRun(runs, draw) {
    const drawn = runs.map((run) => draw(run));
    if (drawn.every((d) => d === null)) return null;
    return html("div", { class: runs.length > 1 ? "runs" : "" }, drawn.map((d, i) => html("div", { class: "card" },
      runs.length > 1 ? html("h3", {}, runs[i].name) : null, d || html("p", { class: "missing" }, "This run has none."))));
  }
  const pair = (runs, ...figures) => html("div", { class: runs.length > 1 ? "" : "pair" }, figures);
  const kShort = { map3d: "Map", errors: "Errors", features: "Features", losses: "Losses", maps: "Maps", graph: "Keyframes", sensors: "Sensors", options: "Options" };
  function add(id, title, note, draw) { kSections.push({ id, title, note, draw, short: kShort[id] || title }); }

  // What several runs are drawn in, so that they can be compared.
  const timeRange = (runs) => [0, Math.max(...runs.map((run) => run.path.t[run.path.t.length - 1]), ...runs.map((run) => (run.lost.length ? run.lost[run.lost.length - 1].t : 0)))];
  const levelled = (run, positions) => positions.map(run.level.apply);
  const positionsOf = (runs) => runs.flatMap((run) => levelled(run, run.path.position.concat(run.errors ? run.errors.truth.position : [])));

  // Neighbouring frames that were lost, as stretches of time.
  function lostBands(run) {
    const bands = [];
    for (const { t } of run.lost) {
      const last = bands[bands.length - 1];
      if (last && t - last[1] < 0.3) last[1] = t; else bands.push([t, t]);
    }
    return bands;
  }
  const bandsOf = (run) => ({ bands: lostBands(run), bandName: "no pose" });

  function table(caption, heads, rows) {
    return html("div", { class: "scroll" }, html("table", {}, html("caption", {}, caption),
      html("thead", {}, html("tr", {}, heads.map((h) => html("th", { scope: "col" }, h)))),
      html("tbody", {}, rows.map((row) => html("tr", {}, row.map((cell, i) => html(i ? "td" : "th", i ? {} : { scope: "row" }, cell)))))));
  }

  add("summary", "Summary", "", (runs) => html("div", {}, runs.length > 1 ? Highwall.comparison(runs) : Highwall.tiles(runs[0]),
    html("div", { class: runs.length > 1 ? "runs" : "", style: "margin-top:1rem" }, runs.map((run) => html("div", { class: "card words" },
      runs.length > 1 ? html("h3", {}, run.name) : null, run.words.map((text) => html("p", {}, text)))))));

  add("map3d", "The map", "Drag to turn, scroll to zoom, right button to move. Keys, once the view is chosen: arrows turn, + and − zoom, W A S D move, Home shows all of it.",
    (runs) => (Highwall.view = Highwall.view3d(runs)).element);

  add("trajectory", "Trajectory", "In metres from where the run began, at one scale, levelled where the map tells what is level; the ground truth is laid on it by a rigid alignment.", (runs) => {
    const all = positionsOf(runs), views = Highwall.viewsOf(all);
    const worst = Math.max(...runs.map((run) => (run.errors ? run.errors.ape.max : 0)));
    return perRun(runs, (run) => {
      const common = run.errors
        ? { values: run.path.error, range: [0, Math.max(1e3 * worst, 1e-3)], colour: Highwall.viridis, label: "error [mm]" }
        : { values: run.path.t, range: timeRange(runs), colour: Highwall.cividis, label: "time [s]" };
      if (run.errors) common.values = run.path.error.map((e) => (e === null ? null : 1e3 * e));
      const plan = (title, axes) => Highwall.pathPlan({ title, axes, extentOf: all, path: levelled(run, run.path.position), t: run.path.t,
        truth: run.errors && levelled(run, run.errors.truth.position), ...common });
      return pair(runs, plan("From above", views.top), plan("From the side", views.side));
    });
  });

  add("errors", "Errors over time", "", (runs) => {
    const known = runs.filter((run) => run.errors);
    if (!known.length) return null;
    const millimetres = (values) => values.map((v) => 1e3 * v);
    const xRange = timeRange(runs);
    const of = (key, title, note) => html("div", { class: "card" }, chart({ title, note, yLabel: "error [mm]", unit: "mm", fromZero: true, xRange, width: 1140, height: 250,
      ...(runs.length === 1 ? bandsOf(runs[0]) : {}),
      series: known.map((run, i) => ({ name: known.length > 1 ? run.name : "", x: run.errors[key].t, y: millimetres(run.errors[key].error), style: "s" + (i % 6) + (i ? " dash" + (i % 3) : "") })),
      ...(known.length === 1 ? { level: 1e3 * known[0].errors[key].rmse, levelName: `RMSE ${number(1e3 * known[0].errors[key].rmse, 3)} mm` } : {}) }));
    return html("div", {}, of("ape", "Absolute pose error", "distance from the ground truth after rigid alignment"),
      of("rpe", "Relative pose error", "drift over one second, at its end"));
  });

  add("features", "Features and losses", "How many points and lines of each frame were matched with the map. Shaded: frames without a pose.", (runs) => {
    const known = runs.filter((run) => run.frames);
    if (!known.length) return null;
    const xRange = timeRange(runs), yRange = sharedRange(known.flatMap((run) => [run.frames.points, run.frames.lines]));
    return perRun(runs, (run) => (run.frames ? chart({ title: "Features tracked", yLabel: "features", xRange, yRange, width: runs.length > 1 ? 560 : 1140, height: 250, ...bandsOf(run),
      series: [{ name: "points", x: run.frames.t, y: run.frames.points, style: "s0" }, { name: "lines", x: run.frames.t, y: run.frames.lines, style: "s1 dash1" }] }) : null));
  });

  add("losses", "Reasons of loss", "", (runs) => perRun(runs, (run) => {
    const reasons = Object.entries(run.run.loss_reasons || {}).sort((a, b) => b[1] - a[1]);
    if (!run.run.frames) return null;
    if (!reasons.length) return html("p", {}, "Every frame has a pose.");
    return table("Frames without a pose, by what kept them from one", ["reason", "frames", "when [s]"], reasons.map(([reason, count]) => {
      const bands = lostBands({ lost: run.lost.filter((l) => l.because === reason) });
      const when = bands.slice(0, 12).map(([a, b]) => (b > a ? `${a.toFixed(1)}–${b.toFixed(1)}` : a.toFixed(1))).join(", ");
      return [reason, String(count), when + (bands.length > 12 ? " …" : "")];
    }));
  }));

  add("maps", "Maps and merges", "Where tracking is lost for good the map goes on in a new one; they become one when they meet.", (runs) => {
    const xRange = timeRange(runs);
    const results = (run) => [["loops that joined maps", get(run, "run/loops/merges")], ["relocalizations", get(run, "run/relocalizations")]].filter(([, v]) => v !== undefined);
    return html("div", {}, runs.map((run) => html("div", { class: "card" }, runs.length > 1 ? html("h3", {}, run.name) : null,
      Highwall.timeline("When each map was tracked", run.maps, run.lost, xRange),
      table("Maps in the end, the one with most frames first", ["map", "trajectory", "frames", "keyframes"],
        run.maps.map((m, i) => [`map ${i + 1}`, m.name, number(m.frames), number(m.keyframes)])),
      html("p", { class: "note" }, results(run).map(([name, v]) => `${name}: ${v}`).join("; ")))));
  });

  add("graph", "Keyframes and loops", "Keyframes from above, with those that they share most landmarks with, and places that were recognized: closed, or refused after a check.", (runs) => perRun(runs, (run) => {
    if (!run.graph.keyframes) return null;
    const plan = Highwall.graphPlan({ title: "Keyframe graph", axes: [0, 1], extentOf: levelled(run, run.path.position), graph: run.graph, loops: run.loops, level: run.level.apply });
    const seconds = (t) => (t === null ? "–" : t.toFixed(1));
    const rows = run.loops.slice(0, 200).map((l, i) => [String(i + 1), l.result, seconds(l.t), seconds(l.t_match), l.because || ""]);
    const list = rows.length ? table(`Places that were recognized: ${run.loops.length}`, ["", "result", "seen at [s]", "known since [s]", "because"], rows)
      : html("p", {}, "No place was recognized that the map did not know to be near.");
    return pair(runs, plan, html("div", {}, list));
  }));

  add("times", "Times", "", (runs) => {
    const known = runs.filter((run) => run.run.milliseconds);
    if (!known.length) return null;
    const kStages = [["points", "points"], ["lines", "lines"], ["features", "features, both"], ["pose", "matching and pose"], ["mapping", "mapping, a keyframe"], ["dense", "dense map, a keyframe"], ["frame", "whole frame"]];
    const stages = (run) => kStages.filter(([key]) => get(run, `run/milliseconds/${key}/count`) > 0).map(([key, name]) => ({ name, ...run.run.milliseconds[key] }));
    const most = 1.05 * Math.max(...known.flatMap((run) => stages(run).map((s) => s.p95)));
    const framed = known.filter((run) => run.frames);
    const yRange = framed.length ? sharedRange(framed.map((run) => run.frames.milliseconds), { logarithmic: true }) : null;
    return perRun(runs, (run) => (run.run.milliseconds ? pair(runs, Highwall.stageBars("Stages", stages(run), most),
      run.frames ? chart({ title: "Each frame", note: "keyframes and loops included", yLabel: "ms", unit: "ms", logarithmic: true, xRange: timeRange(runs), yRange, height: 262,
        series: [{ name: "", x: run.frames.t, y: run.frames.milliseconds, style: "s0" }] }) : null) : null));
  });

  add("imu", "IMU", "The weight w_IMU of the IMU's residuals, how its predictions fit, and what was found of it.", (runs) => {
    const known = runs.filter((run) => run.imu);
    if (!known.length) return null;
    const xRange = timeRange(runs);
    const shared = (pick, options) => sharedRange(known.flatMap(pick), options);
    const weights = shared((run) => [run.imu.weight], { fromZero: true });
    const innovations = shared((run) => [run.imu.innovation_per_dof], { logarithmic: true, level: 1 });
    const axes = (states, key) => [0, 1, 2].map((k) => ({ name: "xyz"[k], x: states.t, y: states[key].map((b) => b[k]), style: ["s0", "s1 dash1", "s2 dash2"][k] }));
    return perRun(runs, (run) => {
      if (!run.imu) return null;
      const t = run.imu.t, states = run.imu.states;
      const figures = [
        chart({ title: "Weight w_IMU", yLabel: "weight", fromZero: true, xRange, yRange: weights, series: [{ name: "", x: t, y: run.imu.weight, style: "s0" }] }),
        chart({ title: "Squared innovation a degree of freedom", note: "1 where the noise is what is said", yLabel: "χ² / dof", logarithmic: true, xRange, yRange: innovations, level: 1, series: [{ name: "", x: t, y: run.imu.innovation_per_dof, style: "s0" }] })];
      if (states) {
        figures.push(
          chart({ title: "Gyroscope bias", yLabel: "rad/s", xRange, series: axes(states, "gyroscope_bias") }),
          chart({ title: "Accelerometer bias", yLabel: "m/s²", xRange, series: axes(states, "accelerometer_bias") }),
          chart({ title: "Offset of the clocks t_d", yLabel: "ms", unit: "ms", xRange, series: [{ name: "", x: states.t, y: states.time_offset.map((v) => 1e3 * v), style: "s3" }] }));
      }
      return pair(runs, figures);
    });
  });

  function sensorRows(run) {
    const rows = [], plusMinus = (value, sigma, factor, unit) => `${number(value * factor, 4)}${sigma > 0 ? " ± " + number(sigma * factor, 2) : ""} ${unit}`;
    const timing = run.run.frame_timing_s;
    if (timing) {
      for (const [key, name] of [["colour_readout", "read-out of colour"], ["depth_readout", "read-out of depth"], ["depth_delay", "delay of depth"]]) {
        rows.push([name, plusMinus(timing.value[key], timing.sigma[key], 1e3, "ms")]);
      }
    }
    const noise = run.run.depth_noise;
    if (noise && noise.baseline === undefined) rows.push(["depth noise at z [m]", `${number(1e3 * noise.offset, 3)} + ${number(1e3 * noise.quadratic, 3)} (z − ${number(noise.reference, 2)})² mm`]);
    const learnt = run.run.noise;
    if (learnt && typeof learnt === "object") for (const [key, value] of Object.entries(learnt)) rows.push(["noise: " + key.replace(/_/g, " "), typeof value === "object" ? JSON.stringify(value) : number(value)]);
    const imu = run.run.imu || {};
    if (imu.depth_scale) rows.push(["true depth over measured", plusMinus(imu.depth_scale.value, imu.depth_scale.sigma, 1, "")]);
    if (imu.time_offset) rows.push(["offset of the clocks t_d", plusMinus(imu.time_offset.value, imu.time_offset.sigma, 1e3, "ms")]);
    for (const [key, name, unit] of [["gyroscope_bias", "gyroscope bias", "rad/s"], ["accelerometer_bias", "accelerometer bias", "m/s²"]]) {
      if (imu[key]) rows.push([name, imu[key].value.map((v, i) => plusMinus(v, imu[key].sigma[i], 1, "")).join(",  ") + unit]);
    }
    const mount = imu.extrinsics;
    if (mount) {
      const unseen = (seen) => (seen ? "" : " (hardly seen)");
      rows.push(["camera in the IMU's frame, x, y, z", mount.lever_arm_m.map((v, i) => plusMinus(v, mount.lever_arm_sigma_m[i], 1e3, "mm") + unseen(mount.lever_arm_seen[i])).join(",  ")]);
      rows.push(["its turn about its x, y, z known to", mount.rotation_sigma_rad.map((v, i) => number((v * 180) / Math.PI, 2) + "°" + unseen(mount.rotation_seen[i])).join(",  ")]);
    }
    if (imu.gravity_sigma_rad) rows.push(["gravity known to", number((imu.gravity_sigma_rad * 180) / Math.PI, 2) + "°"]);
    return rows;
  }
  add("sensors", "What was found of the sensors", "", (runs) => perRun(runs, (run) => {
    const rows = sensorRows(run);
    return rows.length ? table("With one standard deviation", ["", "in the end"], rows) : null;
  }));

  add("pictures", "Pictures", "", (runs) => perRun(runs, (run) => (run.pictures.length ? html("div", { class: "pair" }, run.pictures.map((p) =>
    html("figure", {}, html("figcaption", {}, p.of), html("img", { src: p.src, alt: p.of, loading: "lazy" })))) : null)));

  add("options", "Options and versions", "", (runs) => perRun(runs, (run) => {
    const said = (object) => Object.entries(object || {}).map(([key, value]) => [key.replace(/_/g, " "), typeof value === "object" ? JSON.stringify(value) : String(value)]);
    const what = [["folder", run.folder]].concat(["dataset", "calibration"].filter((key) => run.run[key]).map((key) => [key, run.run[key]]));
    return pair(runs, html("div", {}, table("What was run", ["", ""], what), table("Versions", ["", ""], said(run.run.versions))),
      run.run.options ? html("div", {}, table("Options", ["option", "value"], said(run.run.options))) : null);
  }));
})();
