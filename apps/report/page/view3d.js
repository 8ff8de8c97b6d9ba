"use strict";
// The map in three dimensions: turns with the mouse, with touch and with the keys.
(function () {
  const { html, bytes } = Highwall;
  const kBackground = 0x10151c;

  function vectors(array, low, step) {
    const values = new Float32Array(array.length);
    for (let i = 0; i < array.length; ++i) values[i] = low[i % 3] + step * array[i];
    return values;
  }

  function geometry(position, colour) {
    const made = new THREE.BufferGeometry();
    made.setAttribute("position", new THREE.BufferAttribute(position, 3));
    if (colour) made.setAttribute("color", new THREE.BufferAttribute(colour, 3, true));
    return made;
  }
  // Until revision 113 a number, true from then on.
  const kVertexColours = () => THREE.VertexColors || true;

  function heightColours(position, level) {
    const heights = [];
    for (let i = 0; i < position.length; i += 3) heights.push(level.apply(position.subarray(i, i + 3))[2]);
    const sorted = Float32Array.from(heights).sort();
    const low = sorted[Math.floor(0.02 * (sorted.length - 1))], high = sorted[Math.ceil(0.98 * (sorted.length - 1))];
    const colours = new Uint8Array(position.length);
    heights.forEach((h, i) => colours.set(Highwall.viridis((h - low) / Math.max(high - low, 1e-3)), 3 * i));
    return colours;
  }

  function cloud(data, level) {
    const position = vectors(new Uint16Array(bytes(data.positions)), data.low, data.step);
    const own = new Uint8Array(bytes(data.colours));
    const points = new THREE.Points(geometry(position, own),
      new THREE.PointsMaterial({ size: 2, sizeAttenuation: false, vertexColors: kVertexColours() }));
    points.userData = { own, byHeight: null, position, level };
    return points;
  }

  function colourCloud(points, byHeight) {
    const data = points.userData;
    if (byHeight && !data.byHeight) data.byHeight = heightColours(data.position, data.level);
    points.geometry.setAttribute("color", new THREE.BufferAttribute(byHeight ? data.byHeight : data.own, 3, true));
  }

  // The faces of a cube: normal, corners in units of the edge, how bright.
  const kFaces = [
    { n: [1, 0, 0], c: [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]], light: 0.82 },
    { n: [-1, 0, 0], c: [[-1, 1, -1], [-1, -1, -1], [-1, -1, 1], [-1, 1, 1]], light: 0.82 },
    { n: [0, 1, 0], c: [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]], light: 0.68 },
    { n: [0, -1, 0], c: [[-1, -1, -1], [1, -1, -1], [1, -1, 1], [-1, -1, 1]], light: 0.68 },
    { n: [0, 0, 1], c: [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], light: 1.0 },
    { n: [0, 0, -1], c: [[-1, 1, -1], [1, 1, -1], [1, -1, -1], [-1, -1, -1]], light: 0.5 },
  ];

  // Only faces that no other cell hides.
  function octree(data, level) {
    const cells = new Uint16Array(bytes(data.cells)), taken = new Set();
    const key = (x, y, z) => (x * 65536 + y) * 65536 + z;
    const heights = [];
    for (let i = 0; i < cells.length; i += 3) {
      taken.add(key(cells[i], cells[i + 1], cells[i + 2]));
      heights.push(level.apply([cells[i], cells[i + 1], cells[i + 2]])[2]);
    }
    heights.sort((a, b) => a - b);
    const low = heights[Math.floor(0.02 * (heights.length - 1))], high = heights[Math.ceil(0.98 * (heights.length - 1))];
    const position = [], colour = [], index = [], half = data.size * 0.5;
    for (let i = 0; i < cells.length; i += 3) {
      const cell = [cells[i], cells[i + 1], cells[i + 2]];
      const base = Highwall.viridis((level.apply(cell)[2] - low) / Math.max(high - low, 1));
      for (const face of kFaces) {
        if (taken.has(key(cell[0] + face.n[0], cell[1] + face.n[1], cell[2] + face.n[2]))) continue;
        const at = position.length / 3;
        for (const corner of face.c) {
          for (let k = 0; k < 3; ++k) position.push(data.low[k] + data.size * cell[k] + half * corner[k]);
          for (const c of base) colour.push(Math.round(c * face.light));
        }
        index.push(at, at + 1, at + 2, at, at + 2, at + 3);
      }
    }
    const made = geometry(new Float32Array(position), new Uint8Array(colour));
    made.setIndex(new THREE.BufferAttribute(new Uint32Array(index), 1));
    return new THREE.Mesh(made, new THREE.MeshBasicMaterial({ vertexColors: kVertexColours() }));
  }

  function lineSegments(position, colour) {
    return new THREE.LineSegments(geometry(position), new THREE.LineBasicMaterial({ color: colour }));
  }

  // Interrupted where frames are missing.
  function strip({ t, position }, colour) {
    const gap = Highwall.gapOf(t), ends = [];
    for (let i = 1; i < t.length; ++i) {
      if (t[i] - t[i - 1] <= gap) ends.push(...position[i - 1], ...position[i]);
    }
    return lineSegments(new Float32Array(ends), colour);
  }

  // The camera and the edge of its image, of each keyframe.
  function frusta(keyframes, length) {
    const ends = [], rotation = new THREE.Quaternion();
    for (const keyframe of keyframes) {
      rotation.set(...keyframe.rotation);
      const centre = new THREE.Vector3(...keyframe.position);
      const corners = [[-1, -0.75], [1, -0.75], [1, 0.75], [-1, 0.75]].map(([x, y]) =>
        new THREE.Vector3(0.55 * length * x, 0.55 * length * y, length).applyQuaternion(rotation).add(centre));
      corners.forEach((corner, i) => {
        for (const end of [centre, corner, corner, corners[(i + 1) % 4]]) ends.push(end.x, end.y, end.z);
      });
    }
    return lineSegments(new Float32Array(ends), 0x56b4e9);
  }

  function spread(positions) {
    const box = new THREE.Box3();
    for (const p of positions) box.expandByPoint(new THREE.Vector3(...p));
    return box;
  }

  // The path and some points of the cloud, all but the outermost, and the box about them.
  function extentOf(run, layers) {
    const path = run.path.position.map(run.level.apply), box = spread(path);
    if (!layers.cloud) return { box, points: path };
    const all = layers.cloud.object.userData.position, some = [];
    const stride = 3 * Math.max(1, Math.floor(all.length / 60000));
    for (let i = 0; i < all.length; i += stride) some.push(run.level.apply(all.subarray(i, i + 3)));
    for (let k = 0; k < 3; ++k) {
      const values = some.map((p) => p[k]).sort((a, b) => a - b), axis = "xyz"[k];
      box.min[axis] = Math.min(box.min[axis], values[Math.floor(0.02 * values.length)]);
      box.max[axis] = Math.max(box.max[axis], values[Math.floor(0.98 * (values.length - 1))]);
    }
    return { box, points: path.concat(some.filter((p) => box.containsPoint(new THREE.Vector3(...p)))) };
  }

  // [m] Small enough to distinguish keyframes.
  function frustumLength(run) {
    const places = (run.graph.keyframes || []).map((k) => new THREE.Vector3(...k.position));
    const steps = places.slice(1).map((p, i) => p.distanceTo(places[i])).sort((a, b) => a - b);
    const wanted = 0.05 * spread(run.path.position).getSize(new THREE.Vector3()).length();
    return Math.max(0.03, Math.min(wanted, 2 * (steps[steps.length >> 1] || wanted)));
  }

  function layersOf(run) {
    const layers = {};
    const length = frustumLength(run);
    const add = (name, label, shown, make) => { layers[name] = { label, shown, make, object: null }; };
    if (run.scene.cloud) add("cloud", "cloud", true, () => cloud(run.scene.cloud, run.level));
    if (run.scene.octree) add("octree", "octree", !run.scene.cloud, () => octree(run.scene.octree, run.level));
    if (run.graph.lines) add("lines", "lines", true, () => lineSegments(new Float32Array(bytes(run.graph.lines)), 0xf0a030));
    if (run.graph.keyframes) add("keyframes", "keyframes", true, () => frusta(run.graph.keyframes, length));
    add("path", "path", true, () => strip(run.path, 0xff6f91));
    if (run.errors) add("truth", "ground truth", false, () => strip(run.errors.truth, 0xffffff));
    const loops = run.loops.filter((l) => l.from && l.to && l.result !== "refused");
    if (loops.length) add("loops", "loops", true, () => lineSegments(new Float32Array(loops.flatMap((l) => [...l.from, ...l.to])), 0x40e0a0));
    return layers;
  }

  // Drawn when something has changed, and only then.
  class View {
    constructor(canvas) {
      this.canvas = canvas;
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
      this.renderer.setClearColor(kBackground);
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      this.camera = new THREE.PerspectiveCamera(50, 1, 0.01, 1000);
      this.camera.up.set(0, 0, 1);
      this.controls = new THREE.OrbitControls(this.camera, canvas);
      this.controls.enableKeys = false;
      this.controls.addEventListener("change", () => this.draw());
      this.waiting = false;
      new ResizeObserver(() => this.fit() && this.render()).observe(canvas);
    }
    show(run) {
      this.scene = new THREE.Scene();
      this.world = new THREE.Group();
      this.world.quaternion.set(...run.level.quaternion);
      this.scene.add(this.world);
      this.layers = layersOf(run);
      for (const name of Object.keys(this.layers)) if (this.layers[name].shown) this.toggle(name, true);
      this.extent = extentOf(run, this.layers);
      this.look("oblique");
    }
    toggle(name, shown) {
      const layer = this.layers[name];
      layer.shown = shown;
      if (shown && !layer.object) this.world.add((layer.object = layer.make()));
      if (layer.object) layer.object.visible = shown;
      this.draw();
    }
    look(from) {
      const { box } = this.extent;
      const centre = box.getCenter(new THREE.Vector3()), size = Math.max(box.getSize(new THREE.Vector3()).length(), 0.5);
      const towards = { top: [0, -1e-3, 1], front: [0, -1, 0.02], side: [-1, 0, 0.02], oblique: [-0.75, -0.55, 0.62] }[from];
      const direction = new THREE.Vector3(...towards).normalize();
      this.fit();
      this.controls.target.copy(centre);
      this.camera.position.copy(centre).addScaledVector(direction, this.distanceOfAll(centre, direction));
      this.camera.near = 0.002 * size;
      this.camera.far = 20 * size;
      this.controls.maxDistance = 8 * size;
      this.controls.update();
      this.draw();
    }
    // From how far all points are seen by who looks at `centre` against `direction`.
    distanceOfAll(centre, direction) {
      const right = new THREE.Vector3().crossVectors(this.camera.up, direction).normalize();
      const up = new THREE.Vector3().crossVectors(direction, right);
      const high = Math.tan((this.camera.fov * Math.PI) / 360), wide = high * this.camera.aspect;
      const point = new THREE.Vector3();
      let distance = 0.25;
      for (const p of this.extent.points) {
        point.set(...p).sub(centre);
        const beyond = Math.max(Math.abs(point.dot(right)) / wide, Math.abs(point.dot(up)) / high);
        distance = Math.max(distance, point.dot(direction) + 1.06 * beyond);
      }
      return distance;
    }
    // Angles in radians; zoom: factor of the distance.
    turn(sideways, upwards, zoom) {
      const from = this.camera.position.clone().sub(this.controls.target);
      const distance = from.length() * zoom;
      const polar = Math.min(Math.max(Math.acos(from.z / from.length()) - upwards, 0.01), Math.PI - 0.01);
      const azimuth = Math.atan2(from.y, from.x) + sideways;
      from.set(Math.sin(polar) * Math.cos(azimuth), Math.sin(polar) * Math.sin(azimuth), Math.cos(polar)).multiplyScalar(distance);
      this.camera.position.copy(this.controls.target).add(from);
      this.controls.update();
      this.draw();
    }
    move(right, up) {
      const distance = this.camera.position.distanceTo(this.controls.target);
      const shift = new THREE.Vector3(right * distance, up * distance, 0).applyQuaternion(this.camera.quaternion);
      this.camera.position.add(shift);
      this.controls.target.add(shift);
      this.controls.update();
      this.draw();
    }
    fit() {
      const { clientWidth, clientHeight } = this.canvas, size = `${clientWidth} ${clientHeight}`;
      if (!clientWidth || !clientHeight || size === this.size) return false;
      this.size = size;
      this.camera.aspect = clientWidth / clientHeight;
      this.camera.updateProjectionMatrix();
      this.renderer.setSize(clientWidth, clientHeight, false);
      return true;
    }
    draw() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => { this.waiting = false; this.render(); });
    }
    render() {
      if (this.scene) this.renderer.render(this.scene, this.camera);
    }
    // How many pixels differ from the background: what tests ask for.
    drawnPixels() {
      this.render();
      const gl = this.renderer.getContext(), width = gl.drawingBufferWidth, height = gl.drawingBufferHeight;
      const pixels = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      const ground = [kBackground >> 16, (kBackground >> 8) & 255, kBackground & 255];
      let drawn = 0;
      for (let i = 0; i < pixels.length; i += 4) {
        if (ground.some((c, k) => Math.abs(c - pixels[i + k]) > 2)) ++drawn;
      }
      return drawn;
    }
  }

  const kKeys = {
    ArrowLeft: [-0.12, 0, 1], ArrowRight: [0.12, 0, 1], ArrowUp: [0, 0.1, 1], ArrowDown: [0, -0.1, 1],
    "+": [0, 0, 0.88], "=": [0, 0, 0.88], "-": [0, 0, 1.14],
  };
  const kMoves = { a: [-0.06, 0], d: [0.06, 0], w: [0, 0.06], s: [0, -0.06] };

  function bindKeys(view, canvas) {
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const turn = kKeys[event.key], move = kMoves[event.key.toLowerCase()];
      if (turn) view.turn(...turn);
      else if (move) view.move(...move);
      else if (event.key === "Home") view.look("oblique");
      else return;
      event.preventDefault();
    });
  }

  function layerBoxes(view, place) {
    place.replaceChildren(...Object.entries(view.layers).map(([name, layer]) => {
      const box = html("input", { type: "checkbox" });
      box.checked = layer.shown;
      box.addEventListener("change", () => view.toggle(name, box.checked));
      return html("label", {}, box, layer.label);
    }));
  }

  function controlBar(view, runs) {
    const layers = html("span", { class: "bar", style: "margin:0" });
    const refresh = () => layerBoxes(view, layers);
    const buttons = [["oblique", "Whole"], ["top", "Top"], ["front", "Front"], ["side", "Side"]].map(([from, name]) => {
      const button = html("button", { type: "button" }, name);
      button.addEventListener("click", () => view.look(from));
      return button;
    });
    const byHeight = html("input", { type: "checkbox" });
    byHeight.addEventListener("change", () => {
      if (view.layers.cloud && view.layers.cloud.object) colourCloud(view.layers.cloud.object, byHeight.checked);
      view.draw();
    });
    const size = html("input", { type: "range", min: 1, max: 6, step: 0.5, value: 2, style: "width:5rem" });
    size.addEventListener("input", () => {
      if (view.layers.cloud && view.layers.cloud.object) view.layers.cloud.object.material.size = +size.value;
      view.draw();
    });
    const choose = html("select", { "aria-label": "Run that is shown" }, runs.map((run, i) => html("option", { value: i }, run.name)));
    choose.addEventListener("change", () => { view.show(runs[+choose.value]); byHeight.checked = false; refresh(); });
    refresh();
    return html("div", { class: "bar" }, runs.length > 1 ? choose : null, buttons, layers,
      html("label", {}, byHeight, "by height"), html("label", {}, "points ", size));
  }

  function webgl() {
    const probe = document.createElement("canvas");
    return !!(probe.getContext("webgl2") || probe.getContext("webgl"));
  }

  // The parts that the live view shares.
  Highwall.scene3d = { View, geometry, lineSegments, frusta, spread, kFaces, kVertexColours, bindKeys, layerBoxes, webgl };

  // The element of the view, and what starts it once it is on the page.
  Highwall.view3d = function (runs) {
    if (typeof THREE === "undefined") {
      return { element: html("p", { class: "missing" }, "This page was written by a highwall that was built without three.js (Debian: libjs-three), and has no 3-D view."), state: "absent" };
    }
    if (!webgl()) return { element: html("p", { class: "missing" }, "This browser has no WebGL, so the 3-D view cannot be shown."), state: "no WebGL" };
    const canvas = html("canvas", { tabindex: "0", role: "application", "aria-label":
      "The map in three dimensions. Arrow keys turn it, plus and minus zoom, W A S D move it, Home shows all of it." });
    const element = html("div", { class: "card view" }, canvas);
    const start = () => {
      const view = new View(canvas);
      view.show(runs[0]);
      bindKeys(view, canvas);
      element.append(controlBar(view, runs));
      window.addEventListener("beforeprint", () => view.render());
      return view;
    };
    return { element, start, state: "drawn" };
  };
})();
