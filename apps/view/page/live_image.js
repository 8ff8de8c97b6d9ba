"use strict";
// The current image with its points, lines and dynamic mask.
(function () {
  const { html, bytes } = Highwall;
  const kMatched = "#3fd0a0", kLine = "#ffb454", kOther = "rgba(210, 220, 235, 0.55)", kMask = "#ff33bf";
  const kSubpixels = 8;

  function checkBox(label, colour, changed) {
    const box = html("input", { type: "checkbox" });
    box.checked = true;
    box.addEventListener("change", changed);
    const swatch = html("span", { class: "swatch", "aria-hidden": "true", style: "background:" + colour });
    return { box, element: html("label", {}, box, swatch, label) };
  }

  function pixelsOf(features) {
    const values = new Uint16Array(bytes(features.pixels)), pixels = new Float32Array(values.length);
    for (let i = 0; i < values.length; ++i) pixels[i] = values[i] / kSubpixels;
    return pixels;
  }

  // The element of the picture, and what shows an event of the kind "frame" in it.
  Highwall.liveImage = function () {
    const canvas = html("canvas", { class: "picture", width: 640, height: 480, role: "img", "aria-label": "The current image" });
    const context = canvas.getContext("2d");
    const reason = html("p", { class: "reason" });
    let shown = null, pending = null, busy = false;
    const repaint = () => shown && paint(shown);
    const points = checkBox("points", kMatched, repaint), lines = checkBox("lines", kLine, repaint);
    const others = checkBox("unmatched", kOther, repaint), mask = checkBox("moving objects", kMask, repaint);
    others.box.checked = false;

    function drawPoints(features) {
      const at = pixelsOf(features), radius = canvas.width / 210;
      const part = (from, to, colour, r) => {
        context.fillStyle = colour;
        context.beginPath();
        for (let i = from; i < to; ++i) {
          context.moveTo(at[2 * i] + r, at[2 * i + 1]);
          context.arc(at[2 * i], at[2 * i + 1], r, 0, 2 * Math.PI);
        }
        context.fill();
      };
      if (others.box.checked) part(features.matched, features.count, kOther, 0.6 * radius);
      part(0, features.matched, kMatched, radius);
    }

    function drawLines(features) {
      const at = pixelsOf(features), width = canvas.width / 320;
      const part = (from, to, colour, w) => {
        context.strokeStyle = colour;
        context.lineWidth = w;
        context.beginPath();
        for (let i = from; i < to; ++i) {
          context.moveTo(at[4 * i], at[4 * i + 1]);
          context.lineTo(at[4 * i + 2], at[4 * i + 3]);
        }
        context.stroke();
      };
      if (others.box.checked) part(features.matched, features.count, kOther, 0.6 * width);
      part(0, features.matched, kLine, width);
    }

    function paint({ event, picture, moving }) {
      canvas.width = event.image.width;
      canvas.height = event.image.height;
      context.drawImage(picture, 0, 0, canvas.width, canvas.height);
      if (moving && mask.box.checked) context.drawImage(moving, 0, 0, canvas.width, canvas.height);
      context.lineCap = "round";
      if (event.lines && lines.box.checked) drawLines(event.lines);
      if (event.points && points.box.checked) drawPoints(event.points);
      if (event.state !== "lost") return;
      context.strokeStyle = "#e0561b";
      context.lineWidth = canvas.width / 60;
      context.strokeRect(0, 0, canvas.width, canvas.height);
    }

    const load = (source) => new Promise((done) => {
      if (!source) return done(null);
      const image = new Image();
      image.onload = () => done(image);
      image.onerror = () => done(null);
      image.src = source;
    });

    // While an image is decoded, only the latest of those that arrive is kept.
    async function show(event) {
      if (!event.image) return;
      pending = event;
      if (busy) return;
      busy = true;
      while (pending) {
        const next = pending;
        pending = null;
        const picture = await load("data:image/jpeg;base64," + next.image.jpeg);
        const moving = await load(next.mask && "data:image/png;base64," + next.mask);
        if (!picture) continue;
        shown = { event: next, picture, moving };
        paint(shown);
        canvas.dataset.frame = next.done;
      }
      busy = false;
    }

    function explain(event) {
      const parts = [];
      if (event.reason) parts.push("No pose: " + event.reason + ".");
      if (event.relocalized) parts.push("Relocalized.");
      if (event.repeated) parts.push("The image repeats the previous one.");
      if (event.unobservable) parts.push(`${event.unobservable} direction${event.unobservable > 1 ? "s" : ""} of the pose unobservable.`);
      if (event.imu && event.imu.status !== "running") parts.push(`IMU ${event.imu.status}${event.imu.reason ? ": " + event.imu.reason : ""}.`);
      reason.textContent = parts.join(" ");
    }

    const element = html("div", {}, canvas, html("div", { class: "bar" }, [points, lines, others, mask].map((b) => b.element)), reason);
    return { element, canvas, show: (event) => { explain(event); show(event); } };
  };
})();
