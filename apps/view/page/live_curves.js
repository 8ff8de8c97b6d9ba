"use strict";
// Features, times and the weight of the IMU over time, from the frames of the run.
(function () {
  const { html } = Highwall;
  const kSamples = 400, kWindow = 60;  // [s]
  const kNames = ["t", "points", "lines", "features", "pose", "mapping", "frame", "weight"];

  // All frames so far; a block may arrive again with more of them.
  class Frames {
    constructor() {
      this.count = 0;
      for (const name of kNames) this[name] = [];
      this.anchor = [];
      this.state = [];
      this.p = [];
    }
    set(block) {
      for (let i = 0; i < block.t.length; ++i) {
        const at = block.first + i;
        for (const name of kNames) this[name][at] = block[name][i];
        this.anchor[at] = block.anchor[i];
        this.state[at] = block.state[i];
        this.p[at] = block.p.slice(3 * i, 3 * i + 3);
      }
      this.count = Math.max(this.count, block.first + block.t.length);
    }
  }

  // Indices of at most kSamples frames after a time.
  function chosen(frames, from) {
    let first = 0;
    while (first < frames.count && !(frames.t[first] >= from)) ++first;
    const step = Math.max(1, Math.ceil((frames.count - first) / kSamples)), indices = [];
    for (let i = frames.count - 1; i >= first; i -= step) if (frames.t[i] !== undefined) indices.push(i);
    return indices.reverse();
  }

  // Times without a pose.
  function lostBands(frames, from) {
    const bands = [];
    for (let i = 0; i < frames.count; ++i) {
      if (!(frames.t[i] >= from) || (frames.state[i] !== "l" && frames.state[i] !== "i")) continue;
      const last = bands[bands.length - 1], end = frames.t[Math.min(i + 1, frames.count - 1)];
      if (last && frames.t[i] - last[1] < 1e-3) last[1] = end; else bands.push([frames.t[i], end]);
    }
    return bands;
  }

  Highwall.liveCurves = function () {
    const frames = new Frames(), element = html("div", { class: "curves" });
    const whole = html("input", { type: "checkbox" });
    const places = {};
    for (const name of ["features", "times", "imu"]) {
      places[name] = html("div", { class: "card" });
      if (name !== "imu") element.append(places[name]);
    }

    function draw() {
      if (frames.count < 2) return;
      const from = whole.checked ? 0 : frames.t[frames.count - 1] - kWindow, at = chosen(frames, from);
      const x = at.map((i) => frames.t[i]), pick = (name) => at.map((i) => frames[name][i]);
      const bands = lostBands(frames, from), common = { bands, bandName: "no pose", width: 520, height: 200 };
      places.features.replaceChildren(Highwall.chart({ ...common, title: "Matched features", yLabel: "features", series: [
        { name: "points", x, y: pick("points"), style: "s0" }, { name: "lines", x, y: pick("lines"), style: "s1 dash1" }] }));
      places.times.replaceChildren(Highwall.chart({ ...common, title: "Time of a frame", yLabel: "milliseconds", unit: "ms", series: [
        { name: "frame", x, y: pick("frame"), style: "s5" }, { name: "features", x, y: pick("features"), style: "s0 dash1" },
        { name: "pose", x, y: pick("pose"), style: "s2 dash2" }, { name: "keyframe", x, y: pick("mapping"), style: "s3" }] }));
      const weights = pick("weight").map((w) => (w >= 0 ? w : null));
      if (weights.every((w) => w === null)) return;
      if (!places.imu.parentNode) element.append(places.imu);
      places.imu.replaceChildren(Highwall.chart({ ...common, title: "Weight of the IMU", yLabel: "weight", yRange: [0, 1.05],
        series: [{ x, y: weights, style: "s4" }] }));
    }
    whole.addEventListener("change", draw);
    return { element, frames, draw, choice: html("label", {}, whole, " curves of the whole run") };
  };
})();
