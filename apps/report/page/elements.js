"use strict";
// What all parts of the page share: elements, numbers, colours, decoding.
const Highwall = {};

(function () {
  // A tag with attributes and children; text is text, never markup.
  function fill(node, attributes, children) {
    for (const [key, value] of Object.entries(attributes || {})) {
      if (value !== undefined && value !== null) node.setAttribute(key, value);
    }
    for (const child of children.flat(Infinity)) {
      if (child !== undefined && child !== null) node.append(child);
    }
    return node;
  }
  Highwall.html = (tag, attributes, ...children) =>
    fill(document.createElement(tag), attributes, children);
  Highwall.svg = (tag, attributes, ...children) =>
    fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);

  // Four significant digits, without an exponent where that can be read.
  Highwall.number = function (value, digits = 4) {
    if (value === null || value === undefined || !isFinite(value)) return "–";
    if (value !== 0 && (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e7)) {
      return value.toExponential(Math.max(0, digits - 2)).replace("e", "·10^").replace("^+", "^");
    }
    if (Number.isInteger(value)) return value.toLocaleString("en").replace(/,/g, "\u202f");
    const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value))));
    return value.toFixed(Math.min(decimals, 6));
  };

  // A value to the digits that its standard deviation leaves sense in.
  Highwall.plusMinus = function (value, sigma) {
    if (!(sigma > 0)) return Highwall.number(value);
    const decimals = Math.min(Math.max(0, 1 - Math.floor(Math.log10(sigma))), 8);
    return `${value.toFixed(decimals)} ± ${sigma.toFixed(decimals)}`;
  };

  Highwall.get = function (object, path) {
    return path.split("/").reduce((at, key) => (at === undefined || at === null ? undefined : at[key]), object);
  };

  function scale(hex) {
    const stops = hex.match(/.{6}/g).map((c) => [0, 2, 4].map((i) => parseInt(c.slice(i, i + 2), 16)));
    return function (share) {
      const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
      const i = Math.min(Math.floor(at), stops.length - 2);
      return stops[i].map((c, k) => Math.round(c + (at - i) * (stops[i + 1][k] - c)));
    };
  }
  // Both are legible with every kind of colour vision and grow lighter evenly.
  Highwall.viridis = scale("4401544828783e4a8931688e26828e1f9e8935b7796ece58b5de2bfde725");
  Highwall.cividis = scale("00224e1235703b496c575d6d7071738a8678a59c74c3b369e1cc55fee838");
  Highwall.css = (rgb) => "rgb(" + rgb.join(",") + ")";

  Highwall.bytes = function (base64) {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    return bytes.buffer;
  };

  // Returns the smallest rotation that makes `up` (a unit vector) point along z: the attitude of a map
  // whose camera did not begin level.
  Highwall.levelling = function (up) {
    if (!up || up[2] < -0.9) return { quaternion: [0, 0, 0, 1], apply: (p) => p };
    const [x, y, w] = [up[1], -up[0], 1 + up[2]], length = Math.hypot(x, y, w);
    const [a, b, c] = [x / length, y / length, w / length];
    const apply = ([px, py, pz]) => {
      const t = [2 * b * pz, -2 * a * pz, 2 * (a * py - b * px)];
      return [px + c * t[0] + b * t[2], py + c * t[1] - a * t[2], pz + c * t[2] + a * t[1] - b * t[0]];
    };
    return { quaternion: [a, b, 0, c], apply };
  };

  // Returns the smallest and the largest of the numbers.
  Highwall.extent = function (values, range = [Infinity, -Infinity]) {
    for (const value of values) {
      if (typeof value !== "number" || !isFinite(value)) continue;
      if (value < range[0]) range[0] = value;
      if (value > range[1]) range[1] = value;
    }
    return range;
  };

  // Where a curve is interrupted: neighbours further apart than this [s] have frames missing between.
  Highwall.gapOf = function (t) {
    const steps = [];
    for (let i = 1; i < t.length; ++i) steps.push(t[i] - t[i - 1]);
    steps.sort((a, b) => a - b);
    return Math.max(4 * (steps.length ? steps[steps.length >> 1] : 1), 0.25);
  };

  // About `count` round values in a range.
  Highwall.ticks = function ([low, high], count) {
    const raw = (high - low) / Math.max(1, count);
    if (!(raw > 0)) return [low];
    const power = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 5, 10].find((s) => s * power >= raw * 0.999) * power;
    const ticks = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) ticks.push(i * step);
    return ticks;
  };
  Highwall.tickLabel = function (value, ticks) {
    const step = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : Math.abs(value) || 1;
    if (step >= 1e5 || step < 1e-5) return value === 0 ? "0" : value.toExponential(0);
    return value.toFixed(Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
  };
})();
