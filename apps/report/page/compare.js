"use strict";
// Runs side by side: their figures in one table.
(function () {
  const { html, number, get } = Highwall;

  // better: -1 where less is better, 1 where more is, 0 where neither.
  const kFigures = [
    ["APE, RMSE [mm]", "errors/ape/rmse", 1e3, -1], ["APE, largest [mm]", "errors/ape/max", 1e3, -1],
    ["RPE over a second, RMSE [mm]", "errors/rpe/rmse", 1e3, -1],
    ["frames with a pose [%]", "run/coverage", 100, 1], ["frames", "run/frames", 1, 0],
    ["frames without a pose", "run/lost_frames", 1, -1], ["points matched a frame", "run/matched_per_frame/points", 1, 0],
    ["lines matched a frame", "run/matched_per_frame/lines", 1, 0], ["keyframes", "run/keyframes", 1, 0],
    ["points of the map", "run/landmarks/points", 1, 0], ["lines of the map", "run/landmarks/lines", 1, 0],
    ["loops closed", "run/loops/closed", 1, 0], ["loops refused", "run/loops/refused", 1, 0],
    ["intervals whose readings the images contradict", "run/imu/contradicted_intervals", 1, 0],
    ["intervals with readings at the end of the range", "run/imu/saturated_intervals", 1, 0],
    ["a frame, median [ms]", "run/milliseconds/frame/median", 1, -1], ["a frame, 95 % within [ms]", "run/milliseconds/frame/p95", 1, -1],
    ["a frame, 99 % within [ms]", "run/milliseconds/frame/p99", 1, -1], ["a frame, worst [ms]", "run/milliseconds/frame/worst", 1, -1],
    ["processor time of a frame [ms]", "run/processor_ms_per_frame", 1, -1],
    ["a keyframe's mapping, median [ms]", "run/milliseconds/mapping/median", 1, -1],
    ["memory [MiB]", "run/peak_memory_mib", 1, -1], ["points of the cloud", "run/map/cloud/points", 1, 0],
    ["occupied leaves of the octree", "run/map/octree/occupied_leaves", 1, 0],
  ];

  function row(runs, [name, path, factor, better]) {
    const values = runs.map((run) => get(run, path)).map((v) => (typeof v === "number" ? v * factor : null));
    if (values.every((v) => v === null)) return null;
    const known = values.filter((v) => v !== null);
    const best = better !== 0 && known.length > 1 && new Set(known).size > 1 ? (better < 0 ? Math.min(...known) : Math.max(...known)) : null;
    return html("tr", {}, html("th", { scope: "row" }, name),
      values.map((v) => html("td", { class: "number" + (best !== null && v === best ? " best" : "") }, number(v, 4))));
  }

  function optionRows(runs) {
    const keys = [...new Set(runs.flatMap((run) => Object.keys(run.run.options || {})))];
    const value = (run, key) => JSON.stringify((run.run.options || {})[key]);
    return keys.filter((key) => new Set(runs.map((run) => value(run, key))).size > 1).map((key) =>
      html("tr", {}, html("th", { scope: "row" }, "option " + key.replace(/_/g, " ")),
        runs.map((run) => html("td", { class: "number" }, String((run.run.options || {})[key])))));
  }

  Highwall.comparison = function (runs) {
    return html("div", { class: "card scroll" }, html("table", {},
      html("caption", {}, "A tick is at the better one. Options are listed where they differ."),
      html("thead", {}, html("tr", {}, html("th", { scope: "col" }, ""), runs.map((run) => html("th", { scope: "col", class: "number" }, run.name)))),
      html("tbody", {}, kFigures.map((figure) => row(runs, figure)), optionRows(runs))));
  };

  Highwall.tiles = function (run) {
    const value = (path, factor = 1, digits = 3) => {
      const found = get(run, path);
      return typeof found === "number" ? number(found * factor, digits) : null;
    };
    const tiles = [
      ["APE, RMSE", value("errors/ape/rmse", 1e3), "mm"], ["RPE over 1 s", value("errors/rpe/rmse", 1e3), "mm"],
      ["coverage", value("run/coverage", 100, 4), "%"], ["keyframes", value("run/keyframes"), ""],
      ["map points", value("run/landmarks/points"), ""], ["map lines", value("run/landmarks/lines"), ""],
      ["loops closed", value("run/loops/closed"), ""], ["frame time", value("run/milliseconds/frame/median"), "ms"],
      ["memory", value("run/peak_memory_mib"), "MiB"],
    ];
    return html("dl", { class: "tiles" }, tiles.filter(([, v]) => v !== null).map(([name, v, unit]) =>
      html("div", {}, html("dt", {}, name), html("dd", {}, v, unit ? html("small", {}, " " + unit) : null))));
  };
})();
