"use strict";
// The sections of the page: each takes the runs and gives an element, or null where there is
// nothing to show.
(function () {
  const { html, number, plusMinus, chart, sharedRange, get } = Highwall;
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

  const kLongTable = 30;  // rows; a longer one scrolls
  function table(caption, heads, rows) {
    const headed = heads.some((h) => h !== "");
    return html("div", { class: "scroll" + (rows.length > kLongTable ? " long" : "") }, html("table", {}, html("caption", {}, caption),
      headed ? html("thead", {}, html("tr", {}, heads.map((h) => html("th", { scope: "col" }, h)))) : null,
      html("tbody", {}, rows.map((row) => html("tr", {}, row.map((cell, i) => html(i ? "td" : "th", i ? {} : { scope: "row" }, cell)))))));
  }

  add("summary", "Summary", "", (runs) => html("div", {}, runs.length > 1 ? Highwall.comparison(runs) : Highwall.tiles(runs[0]),
    html("div", { class: runs.length > 1 ? "runs" : "", style: "margin-top:1rem" }, runs.map((run) => html("div", { class: "card words" },
      runs.length > 1 ? html("h3", {}, run.name) : null, run.words.map((text) => html("p", {}, text)))))));

  add("map3d", "The map", "Drag to turn, scroll to zoom, right button to move. Keys, once the view is chosen: arrows turn, + and − zoom, W A S D move, Home shows all of it.",
    (runs) => (Highwall.view = Highwall.view3d(runs)).element);

  add("trajectory", "Trajectory", "In metres from where the run began, at one scale, aligned with gravity where the map knows its direction; the ground truth is laid on it by a rigid alignment.", (runs) => {
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
      series: [["points", "s0"], ["lines", "s1 dash1"]].filter(([name]) => run.frames[name].some((n) => n > 0))
        .map(([name, style]) => ({ name, x: run.frames.t, y: run.frames[name], style })) }) : null));
  });

  const reasonsOf = (run) => Object.entries(run.run.loss_reasons || {}).sort((a, b) => b[1] - a[1]);
  add("losses", "Reasons of loss", "", (runs) => (runs.every((run) => !reasonsOf(run).length) ? null : perRun(runs, (run) => {
    const reasons = reasonsOf(run);
    if (!run.run.frames) return null;
    if (!reasons.length) return html("p", {}, "Every frame has a pose.");
    return table("Frames without a pose, by what kept them from one", ["reason", "frames", "when [s]"], reasons.map(([reason, count]) => {
      const bands = lostBands({ lost: run.lost.filter((l) => l.because === reason) });
      const when = bands.slice(0, 12).map(([a, b]) => (b > a ? `${a.toFixed(1)}–${b.toFixed(1)}` : a.toFixed(1))).join(", ");
      return [reason, String(count), when + (bands.length > 12 ? " …" : "")];
    }));
  })));

  add("maps", "Maps and merges", "Where tracking is lost for longer than the lost timeout, a new map begins; maps that meet are merged.", (runs) => {
    const isReported = (run) => run.maps.length > 1 || run.lost.length > 0 || get(run, "run/loops/merges") > 0 || get(run, "run/relocalizations") > 0;
    if (!runs.some(isReported)) return null;
    const xRange = timeRange(runs);
    const results = (run) => [["loops that joined maps", get(run, "run/loops/merges")], ["relocalizations", get(run, "run/relocalizations")]].filter(([, v]) => v !== undefined);
    return html("div", {}, runs.map((run) => html("div", { class: "card" }, runs.length > 1 ? html("h3", {}, run.name) : null,
      Highwall.timeline("When each map was tracked", run.maps, run.lost, xRange),
      table("Maps in the end, the one with most frames first", ["map", "trajectory", "frames", "keyframes"],
        run.maps.map((m, i) => [`map ${i + 1}`, m.name, number(m.frames), number(m.keyframes)])),
      html("p", { class: "note" }, results(run).map(([name, v]) => `${name}: ${v}`).join("; ")))));
  });

  add("graph", "Keyframes and loops", "Keyframes with those that they share most landmarks with, and places that were recognized: closed, or refused after a check.", (runs) => perRun(runs, (run) => {
    if (!run.graph.keyframes) return null;
    const extentOf = runs.flatMap((one) => levelled(one, one.path.position)), views = Highwall.viewsOf(extentOf);
    const plan = (title, axes) => Highwall.graphPlan({ title, axes, extentOf, graph: run.graph, loops: run.loops, level: run.level.apply });
    const seconds = (t) => (t === null ? "–" : t.toFixed(1));
    const rows = run.loops.slice(0, 200).map((l, i) => [String(i + 1), l.result, seconds(l.t), seconds(l.t_match), l.because || ""]);
    const list = rows.length ? table(`Places that were recognized: ${run.loops.length}`, ["", "result", "seen at [s]", "known since [s]", "because"], rows)
      : html("p", {}, "No place was recognized that the map did not know to be near.");
    const top = plan("Keyframes from above", views.top);
    if (rows.length || runs.length > 1) return pair(runs, top, html("div", {}, list));
    return html("div", {}, pair(runs, top, plan("Keyframes from the side", views.side)), list);
  }));

  add("times", "Times", "", (runs) => {
    const known = runs.filter((run) => run.run.milliseconds);
    if (!known.length) return null;
    const kNoTime = 0.005;  // [ms] of a stage that was left out
    const kStages = [["points", "points"], ["lines", "lines"], ["features", "features, both"], ["pose", "matching and pose"], ["mapping", "mapping, a keyframe"], ["dense", "dense map, a keyframe"], ["frame", "whole frame"]];
    const stages = (run) => kStages.filter(([key]) => get(run, `run/milliseconds/${key}/p95`) > kNoTime).map(([key, name]) => ({ name, ...run.run.milliseconds[key] }));
    const most = 1.05 * Math.max(...known.flatMap((run) => stages(run).map((s) => s.p95)));
    const framed = known.filter((run) => run.frames);
    const yRange = framed.length ? sharedRange(framed.map((run) => run.frames.milliseconds), { logarithmic: true }) : null;
    return perRun(runs, (run) => (run.run.milliseconds ? pair(runs, Highwall.stageBars("Stages", stages(run), most),
      run.frames ? chart({ title: "Each frame", note: "keyframes, loops and waits included", yLabel: "time [ms]", unit: "ms", logarithmic: true, xRange: timeRange(runs), yRange, height: 262,
        series: [{ name: "", x: run.frames.t, y: run.frames.milliseconds, style: "s0" }] }) : null) : null));
  });

  // What is counted of the IMU over the run.
  function imuRows(imu) {
    const share = imu.reduced_share === undefined ? undefined : 100 * imu.reduced_share;
    return [["mean weight", imu.mean_weight], ["images whose weight is less than 1 [%]", share],
      ["squared innovation a degree of freedom, mean", imu.innovation_per_dof],
      ["frames with a pose by the IMU alone", imu.dead_reckoned_frames], ["restarts", imu.restarts],
      ["intervals whose readings the images contradict", imu.contradicted_intervals],
      ["intervals with readings at the end of the range", imu.saturated_intervals],
    ].filter(([, value]) => typeof value === "number").map(([name, value]) => [name, number(value, 3)]);
  }

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
        chart({ title: "Squared innovation a degree of freedom", note: "1 where the noise is as stated", yLabel: "χ² / dof", logarithmic: true, xRange, yRange: innovations, level: 1, series: [{ name: "", x: t, y: run.imu.innovation_per_dof, style: "s0" }] })];
      if (states) {
        figures.push(
          chart({ title: "Gyroscope bias", yLabel: "bias [rad/s]", unit: "rad/s", xRange, series: axes(states, "gyroscope_bias") }),
          chart({ title: "Accelerometer bias", yLabel: "bias [m/s²]", unit: "m/s²", xRange, series: axes(states, "accelerometer_bias") }),
          chart({ title: "Offset of the clocks t_d", yLabel: "t_d [ms]", unit: "ms", xRange, series: [{ name: "", x: states.t, y: states.time_offset.map((v) => 1e3 * v), style: "s3" }] }));
      }
      figures.push(html("div", {}, table("Over the run", ["", ""], imuRows(run.run.imu))));
      return pair(runs, figures);
    });
  });

  // A row time is observed if its sigma is below a fifth of that of its prior.
  const kSeenRowTime = 0.003;  // [s]
  const kLearnt = {
    point_px_by_level: "pixels of points, level by level of the pyramid",
    low_contrast_px_by_level: "pixels of points of low contrast, level by level",
    refined_px_by_level: "pixels of points that keyframes refined, level by level",
    point_depth_by_depth: "depth of points, to 1, 2, 4 m and beyond",
    edge_depth_by_depth: "depth of points at edges, to 1, 2, 4 m and beyond",
    line_px_by_length: "pixels of lines, to 1/16, 1/8, 1/4 of the image's width and beyond",
    line_depth_by_depth: "depth of lines, to 1, 2, 4 m and beyond",
  };
  const hardly = (seen) => (seen ? "" : " (hardly observed)");
  const listOf = (values, sigmas, factor) => values.map((v, i) => plusMinus(factor * v, factor * sigmas[i]));

  function timingRows({ value, sigma }) {
    return [["colour_readout", "read-out of colour"], ["depth_readout", "read-out of depth"], ["depth_delay", "delay of depth"]].map(([key, name]) =>
      [name, plusMinus(1e3 * value[key], 1e3 * sigma[key]) + " ms" + hardly(sigma[key] < kSeenRowTime)]);
  }

  function noiseRows(run) {
    const rows = [], noise = run.depth_noise, learnt = run.noise;
    if (noise && noise.baseline === undefined) {
      const z = noise.reference ? `(z − ${number(noise.reference, 2)})²` : "z²";
      rows.push(["noise of depth at z [m], as stated", (noise.offset ? `${number(1e3 * noise.offset, 3)} + ` : "") + `${number(1e3 * noise.quadratic, 3)} ${z} mm`]);
    }
    if (learnt && typeof learnt === "object") {
      for (const [key, name] of Object.entries(kLearnt)) {
        if (Array.isArray(learnt[key])) rows.push([`noise found over noise stated: ${name}`, learnt[key].map((v) => v.toFixed(2)).join(",  ")]);
      }
    }
    return rows;
  }

  function patternRows(pattern) {
    if (!pattern || !(pattern.rms_per_m > 0)) return [];
    return [["correction of the depth distortion, at 1 m (RMS)", number(100 * pattern.rms_per_m, 2) + " %"]];
  }

  function imuStateRows(imu) {
    const rows = [];
    if (imu.depth_scale) rows.push(["true depth over measured", plusMinus(imu.depth_scale.value, imu.depth_scale.sigma)]);
    if (imu.time_offset) rows.push(["offset of the clocks t_d", plusMinus(1e3 * imu.time_offset.value, 1e3 * imu.time_offset.sigma) + " ms"]);
    for (const [key, name, unit] of [["gyroscope_bias", "gyroscope bias x, y, z", "rad/s"], ["accelerometer_bias", "accelerometer bias x, y, z", "m/s²"]]) {
      if (imu[key]) rows.push([name, listOf(imu[key].value, imu[key].sigma, 1).join(",  ") + " " + unit]);
    }
    const mount = imu.extrinsics;
    if (mount) {
      rows.push(["camera in the IMU's frame x, y, z", listOf(mount.lever_arm_m, mount.lever_arm_sigma_m, 1e3).map((v, i) => v + " mm" + hardly(mount.lever_arm_seen[i])).join(",  ")]);
      rows.push(["its turn about its x, y, z known to", mount.rotation_sigma_rad.map((v, i) => number((v * 180) / Math.PI, 2) + "°" + hardly(mount.rotation_seen[i])).join(",  ")]);
    }
    if (imu.gravity_sigma_rad) rows.push(["gravity known to", number((imu.gravity_sigma_rad * 180) / Math.PI, 2) + "°"]);
    return rows;
  }

  function sensorRows({ run }) {
    return [].concat(run.frame_timing_s ? timingRows(run.frame_timing_s) : [], patternRows(run.depth_pattern), noiseRows(run), imuStateRows(run.imu || {}));
  }
  add("sensors", "What was found of the sensors", "", (runs) => perRun(runs, (run) => {
    const rows = sensorRows(run);
    return rows.length ? table("In the end, with one standard deviation", ["", ""], rows) : null;
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
