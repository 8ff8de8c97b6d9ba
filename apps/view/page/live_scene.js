"use strict";
// The map in three dimensions while it grows: clouds of keyframes, which move with them, cubes of
// the octree, keyframes, loops, the path and the camera.
(function () {
  const { html, bytes } = Highwall;
  const kBudget = 400000, kSmallestBudget = 30000;  // points that are drawn
  const kSlow = 45;                                 // [ms] to draw: fewer points are

  function poseOf(values, i) {
    return { position: new THREE.Vector3(values[i], values[i + 1], values[i + 2]),
      rotation: new THREE.Quaternion(values[i + 3], values[i + 4], values[i + 5], values[i + 6]) };
  }

  class LiveScene {
    constructor(canvas, frames) {
      const { View } = Highwall.scene3d;
      this.frames = frames;
      this.view = new View(canvas);
      this.view.scene = new THREE.Scene();
      this.view.world = new THREE.Group();
      this.view.scene.add(this.view.world);
      this.keyframes = new Map();  // id -> {world, active, position, rotation}
      this.clouds = new Map();     // id -> Points
      this.cubes = new Map();      // world/corner -> {block, mesh}
      this.loops = [];
      this.world = 0;
      this.chosen = null;          // world that the user has chosen
      this.budget = kBudget;
      this.heights = [0, 1];
      this.follow = true;          // the whole map is kept in view until the user turns it
      this.dirty = new Set();
      this.view.layers = {};
      for (const [name, label, shown] of [["cloud", "cloud", true], ["octree", "octree", false], ["keyframes", "keyframes", true],
        ["path", "path", true], ["loops", "loops", true], ["camera", "camera", true]]) {
        const object = new THREE.Group();
        object.visible = shown;
        this.view.world.add(object);
        this.view.layers[name] = { label, shown, object };
      }
      this.view.extent = { box: Highwall.scene3d.spread([[-1, -1, -1], [1, 1, 1]]), points: [[-1, -1, -1], [1, 1, 1]] };
      this.view.look("oblique");
      for (const kind of ["pointerdown", "wheel", "keydown"]) canvas.addEventListener(kind, () => { this.follow = false; });
    }

    // Blocks of the scene, as docs/view.md describes them.
    keyframesBlock(block) {
      const poses = new Float32Array(bytes(block.poses));
      block.id.forEach((id, i) => {
        this.keyframes.set(id, { id, world: block.world[i], active: block.active[i] === 1, ...poseOf(poses, 7 * i) });
        this.place(id);
      });
      this.touch("keyframes", "path", "loops", "extent");
    }
    cloudBlock(block) {
      const { geometry, kVertexColours } = Highwall.scene3d;
      const steps = new Int16Array(bytes(block.positions)), position = new Float32Array(steps.length);
      for (let i = 0; i < steps.length; ++i) position[i] = block.step * steps[i];
      const points = new THREE.Points(geometry(position, new Uint8Array(bytes(block.colours))),
        new THREE.PointsMaterial({ size: 2, sizeAttenuation: false, vertexColors: kVertexColours() }));
      const before = this.clouds.get(block.id), group = this.view.layers.cloud.object;
      if (before) { group.remove(before); before.geometry.dispose(); }
      this.clouds.set(block.id, points);
      group.add(points);
      this.place(block.id);
      this.touch("share", "extent");
    }
    octreeBlock(block) {
      const key = block.world + "/" + block.corner.join(",");
      if (block.size > (this.cellSize || 0)) {
        for (const [at, cube] of this.cubes) if (cube.block.size < block.size) this.removeCube(at);
        this.cellSize = block.size;
      }
      this.removeCube(key);
      if (block.count > 0) this.cubes.set(key, { block, mesh: null });
      this.touch("octree");
    }
    loopsBlock(block) {
      this.loops = block.loops;
      this.touch("loops");
    }
    removeCube(key) {
      const cube = this.cubes.get(key);
      if (cube && cube.mesh) { this.view.layers.octree.object.remove(cube.mesh); cube.mesh.geometry.dispose(); }
      this.cubes.delete(key);
    }
    frame(event) {
      if (event.world !== undefined && this.chosen === null && event.world !== this.world) this.show(event.world);
      this.pose = event.pose && event.world === this.world ? poseOf(event.pose, 0) : null;
      this.touch("camera", "path");
    }
    // Shows another world.
    show(world) {
      this.world = world;
      for (const id of this.clouds.keys()) this.place(id);
      this.follow = true;
      this.touch("keyframes", "path", "loops", "octree", "share", "extent", "camera");
    }
    worlds() {
      const counts = new Map();
      for (const k of this.keyframes.values()) if (k.active && k.world >= 0) counts.set(k.world, (counts.get(k.world) || 0) + 1);
      return counts;
    }

    touch(...parts) {
      for (const part of parts) this.dirty.add(part);
    }
    place(id) {
      const points = this.clouds.get(id), keyframe = this.keyframes.get(id);
      if (!points) return;
      points.visible = !!keyframe && keyframe.active && keyframe.world === this.world;
      if (!keyframe) return;
      points.position.copy(keyframe.position);
      points.quaternion.copy(keyframe.rotation);
    }
    // Points are in random order: the first of each cloud stand for all of them.
    share() {
      this.total = 0;
      for (const points of this.clouds.values()) if (points.visible) this.total += points.geometry.attributes.position.count;
      const share = Math.min(1, this.budget / Math.max(1, this.total));
      for (const points of this.clouds.values()) points.geometry.setDrawRange(0, Math.ceil(share * points.geometry.attributes.position.count));
      this.drawn = Math.round(share * this.total);
    }
    replace(name, object) {
      const group = this.view.layers[name].object;
      for (const child of [...group.children]) { group.remove(child); child.geometry.dispose(); }
      if (object) group.add(object);
    }
    shownKeyframes() {
      return [...this.keyframes.values()].filter((k) => k.active && k.world === this.world);
    }
    frustumLength() {
      const places = this.shownKeyframes().map((k) => k.position);
      const steps = places.slice(1).map((p, i) => p.distanceTo(places[i])).sort((a, b) => a - b);
      return Math.max(0.03, Math.min(0.6 * (steps[steps.length >> 1] || 0.1), 0.5));
    }
    drawKeyframes() {
      const shown = this.shownKeyframes().map((k) => ({ position: k.position.toArray(), rotation: k.rotation.toArray() }));
      this.replace("keyframes", Highwall.scene3d.frusta(shown, this.frustumLength()));
    }
    drawPath() {
      const { frames } = this, ends = [], p = new THREE.Vector3(), last = new THREE.Vector3();
      let before = -2;
      for (let i = 0; i < frames.count; ++i) {
        const keyframe = frames.anchor[i] >= 0 ? this.keyframes.get(frames.anchor[i]) : undefined;
        if (!keyframe || keyframe.world !== this.world) continue;
        p.set(...frames.p[i]).applyQuaternion(keyframe.rotation).add(keyframe.position);
        if (before === i - 1) ends.push(last.x, last.y, last.z, p.x, p.y, p.z);
        last.copy(p);
        before = i;
      }
      this.replace("path", Highwall.scene3d.lineSegments(new Float32Array(ends), 0xff6f91));
    }
    drawLoops() {
      const ends = [];
      for (const [from, to, accepted] of this.loops) {
        const a = this.keyframes.get(from), b = this.keyframes.get(to);
        if (accepted && a && b && a.world === this.world && b.world === this.world) ends.push(...a.position.toArray(), ...b.position.toArray());
      }
      this.replace("loops", Highwall.scene3d.lineSegments(new Float32Array(ends), 0x40e0a0));
    }
    drawCamera() {
      const camera = this.pose && Highwall.scene3d.frusta([{ position: this.pose.position.toArray(), rotation: this.pose.rotation.toArray() }], 2 * this.frustumLength());
      if (camera) camera.material.color.set(0xffe066);
      this.replace("camera", camera);
    }
    // Only faces that no other cell of the cube hides.
    cubeMesh({ block }) {
      const { geometry, kFaces, kVertexColours } = Highwall.scene3d;
      const { size, corner, side } = block, cells = new Uint16Array(bytes(block.cells)), taken = new Set(cells);
      const position = [], colour = [], index = [], [low, high] = this.heights;
      for (const cell of cells) {
        const at = [cell % side, Math.floor(cell / side) % side, Math.floor(cell / (side * side))];
        const centre = at.map((c, k) => size * (corner[k] + c + 0.5));
        const base = Highwall.viridis((centre[2] - low) / Math.max(high - low, 1e-3));
        for (const face of kFaces) {
          const next = at.map((c, k) => c + face.n[k]);
          if (next.every((c) => c >= 0 && c < side) && taken.has(next[0] + side * (next[1] + side * next[2]))) continue;
          const first = position.length / 3;
          for (const c of face.c) {
            for (let k = 0; k < 3; ++k) position.push(centre[k] + 0.5 * size * c[k]);
            for (const b of base) colour.push(Math.round(b * face.light));
          }
          index.push(first, first + 1, first + 2, first, first + 2, first + 3);
        }
      }
      const made = geometry(new Float32Array(position), new Uint8Array(colour));
      made.setIndex(new THREE.BufferAttribute(new Uint32Array(index), 1));
      return new THREE.Mesh(made, new THREE.MeshBasicMaterial({ vertexColors: kVertexColours() }));
    }
    drawOctree() {
      if (!this.view.layers.octree.shown) return;
      const group = this.view.layers.octree.object;
      for (const cube of this.cubes.values()) {
        if (!cube.mesh) group.add((cube.mesh = this.cubeMesh(cube)));
        cube.mesh.visible = cube.block.world === this.world;
      }
    }
    // The keyframes and some points of their clouds, all but the outermost.
    measure() {
      const positions = this.shownKeyframes().map((k) => k.position.toArray()), some = [], p = new THREE.Vector3();
      for (const [id, points] of this.clouds) {
        if (!points.visible) continue;
        const { array } = points.geometry.attributes.position, keyframe = this.keyframes.get(id);
        for (let i = 0; i < Math.min(array.length, 120); i += 3) {
          some.push(p.set(array[i], array[i + 1], array[i + 2]).applyQuaternion(keyframe.rotation).add(keyframe.position).toArray());
        }
      }
      if (positions.length === 0) return;
      const box = Highwall.scene3d.spread(positions);
      for (let k = 0; k < 3 && some.length > 0; ++k) {
        const values = some.map((q) => q[k]).sort((a, b) => a - b), axis = "xyz"[k];
        box.min[axis] = Math.min(box.min[axis], values[Math.floor(0.02 * values.length)]);
        box.max[axis] = Math.max(box.max[axis], values[Math.floor(0.98 * (values.length - 1))]);
      }
      const before = this.view.extent.box, inside = some.filter((q) => box.containsPoint(new THREE.Vector3(...q)));
      this.view.extent = { box, points: positions.concat(inside) };
      const low = box.min.z, high = Math.max(box.max.z, low + 0.5), range = this.heights[1] - this.heights[0];
      if (Math.abs(low - this.heights[0]) + Math.abs(high - this.heights[1]) > 0.15 * range) {
        this.heights = [low, high];
        for (const [key, cube] of [...this.cubes]) { this.removeCube(key); this.cubes.set(key, { block: cube.block, mesh: null }); }
        this.touch("octree");
      }
      const grown = before.min.distanceTo(box.min) + before.max.distanceTo(box.max);
      if (this.follow && grown > 0.03 * box.getSize(p).length()) this.view.look("oblique");
    }
    // Draws what has changed. Called a few times a second.
    update() {
      if (this.dirty.size === 0) return;
      const has = (part) => this.dirty.has(part), begin = performance.now();
      if (has("extent")) this.measure();
      if (has("share")) this.share();
      if (has("keyframes")) this.drawKeyframes();
      if (has("path")) this.drawPath();
      if (has("loops")) this.drawLoops();
      if (has("octree")) this.drawOctree();
      if (has("camera")) this.drawCamera();
      this.dirty.clear();
      this.view.render();
      const milliseconds = performance.now() - begin;
      this.slow = 0.8 * (this.slow || 0) + 0.2 * milliseconds;
      if (this.slow > kSlow && this.budget > kSmallestBudget && this.drawn > 0.5 * this.budget) {
        this.budget = Math.max(kSmallestBudget, 0.7 * this.budget);
        this.slow = 0;
        this.touch("share");
      }
    }
  }

  function controls(scene) {
    const layers = html("span", { class: "bar", style: "margin:0" });
    Highwall.scene3d.layerBoxes(scene.view, layers);
    layers.addEventListener("change", () => { scene.touch("octree"); scene.update(); });
    const buttons = [["oblique", "Whole"], ["top", "Top"], ["front", "Front"], ["side", "Side"]].map(([from, name]) => {
      const button = html("button", { type: "button" }, name);
      button.addEventListener("click", () => { scene.follow = from === "oblique"; scene.view.look(from); });
      return button;
    });
    const worlds = html("select", { "aria-label": "Map that is shown" });
    worlds.hidden = true;
    worlds.addEventListener("change", () => {
      scene.chosen = worlds.value === "" ? null : +worlds.value;
      if (scene.chosen !== null) scene.show(scene.chosen);
    });
    const refresh = () => {
      const counts = [...scene.worlds()], text = counts.map(([w, n]) => w + ":" + n).join();
      worlds.hidden = counts.length < 2;
      if (text === worlds.dataset.counts || document.activeElement === worlds) return;
      worlds.dataset.counts = text;
      worlds.replaceChildren(html("option", { value: "" }, "map of the camera"),
        ...counts.map(([w, n]) => html("option", { value: w }, `map ${w + 1}: ${n} keyframes`)));
      worlds.value = scene.chosen === null ? "" : scene.chosen;
    };
    return { element: html("div", { class: "bar" }, worlds, buttons, layers), refresh };
  }

  // Returns null without three.js or WebGL, with the reason in the element.
  Highwall.liveScene = function (place, frames) {
    const missing = (why) => { place.append(html("p", { class: "missing" }, why)); return null; };
    if (typeof THREE === "undefined") return missing("This highwall was built without three.js (Debian: libjs-three), and has no 3-D view.");
    if (!Highwall.scene3d.webgl()) return missing("This browser has no WebGL, so the 3-D view cannot be shown.");
    const canvas = html("canvas", { tabindex: "0", role: "application", "aria-label":
      "The map in three dimensions. Arrow keys turn it, plus and minus zoom, W A S D move it, Home shows all of it." });
    place.append(canvas);
    const scene = new LiveScene(canvas, frames), bar = controls(scene);
    Highwall.scene3d.bindKeys(scene.view, canvas);
    place.append(bar.element);
    scene.refresh = bar.refresh;
    return scene;
  };
})();
