"use strict";
// Connects the page with the run: events of the server on one side, buttons on the other. The root
// element says in data-state "open" while events arrive.
(function () {
  const { html, number } = Highwall;
  const root = document.documentElement, find = (id) => document.getElementById(id);
  window.addEventListener("error", (event) => { root.dataset.error = event.message; });

  const image = Highwall.liveImage(), curves = Highwall.liveCurves();
  find("image").append(image.element);
  find("curves").replaceWith(curves.element);
  const scene = Highwall.liveScene(find("scene"), curves.frames);
  Highwall.live = { image, curves, scene };

  const query = location.search, badge = find("state");
  let control = { paused: false, stopped: false }, last = null, ended = false, received = 0, dropped = 0;

  function showState() {
    const state = control.stopped ? "stopping" : control.paused ? "paused" : last ? last.state : "waiting for a frame";
    badge.textContent = state + (last && last.reason && !control.paused && !control.stopped ? ": " + last.reason : "");
    badge.className = "badge " + state;
  }
  function notify(text) {
    find("notice").textContent = text;
    find("notice").hidden = !text;
  }

  const tile = (name, value, unit) => html("div", {}, html("dt", {}, name), html("dd", {}, value, unit ? html("small", {}, " " + unit) : null));
  function showNumbers(event) {
    const { map, times } = event;
    const tiles = [
      tile("frame", number(times.frame, 3), "ms"), tile("points matched", event.points ? `${event.points.matched}` : "–", event.points ? `of ${event.points.count}` : ""),
      tile("lines matched", event.lines ? `${event.lines.matched}` : "–", event.lines ? `of ${event.lines.count}` : ""),
      tile("keyframes", number(map.keyframes)), tile("points in the map", number(map.points)), tile("lines in the map", number(map.lines)),
      tile("loops closed", number(map.loops), map.refused ? `${map.refused} refused` : ""), tile("maps", number(map.submaps), map.merges ? `${map.merges} merged` : "")];
    if (event.imu) tiles.push(tile("weight of the IMU", number(event.imu.weight, 3), event.imu.status));
    if (event.dropped) tiles.push(tile("frames dropped", number(event.dropped)));
    find("tiles").replaceChildren(...tiles);
    find("progress").textContent = `frame ${event.done} of ${event.total}, ${event.t.toFixed(1)} s`;
  }
  function showTraffic() {
    const parts = [`${number(received / 1e6, 3)} MB received`];
    if (scene && scene.total) parts.push(`${number(scene.drawn)} of ${number(scene.total)} points drawn`);
    parts.push(dropped ? `${number(dropped)} updates dropped because this client is slow` : "no update dropped");
    find("traffic").replaceChildren(parts.join(", ") + ". ", curves.choice);
  }

  const buttons = {};
  async function press(command) {
    const answer = await fetch("/button/" + command + query, { method: "POST", headers: { "X-Highwall-Button": "1" } }).catch(() => null);
    if (!answer || !answer.ok) notify(`The run did not take the command "${command}".`);
  }
  function addButton(name, label, act) {
    buttons[name] = html("button", { type: "button", id: "button-" + name }, label);
    buttons[name].addEventListener("click", act);
    find("buttons").append(buttons[name]);
  }
  addButton("pause", "Pause", () => press(control.paused ? "resume" : "pause"));
  addButton("step", "Step", () => press("step"));
  addButton("save", "Save map", () => press("save"));
  // The second press within a few seconds counts.
  addButton("stop", "Stop", () => {
    if (buttons.stop.classList.contains("sure")) { press("stop"); return; }
    buttons.stop.classList.add("sure");
    buttons.stop.textContent = "Really stop?";
    setTimeout(() => { buttons.stop.classList.remove("sure"); buttons.stop.textContent = "Stop"; }, 3000);
  });
  function showControl() {
    buttons.pause.textContent = control.paused ? "Resume" : "Pause";
    for (const button of Object.values(buttons)) button.disabled = ended || control.stopped;
    showState();
  }

  const handlers = {
    frame(event) {
      last = event;
      image.show(event);
      showNumbers(event);
      showState();
      if (scene) scene.frame(event);
      root.dataset.frame = event.done;
    },
    block(block) {
      if (block.kind === "frames") { curves.frames.set(block); if (scene) scene.touch("path"); }
      else if (scene && scene[block.kind + "Block"]) scene[block.kind + "Block"](block);
    },
    control(now) { control = now; showControl(); },
    note(text) { notify(text); },
    dropped(count) { dropped = count; },
    ended({ report }) {
      ended = true;
      events.close();
      showControl();
      root.dataset.state = "ended";
      if (report) location.replace("/report" + query); else notify("The run has ended.");
    },
  };
  const events = new EventSource("/events" + query);
  events.onopen = () => { root.dataset.state = "open"; showControl(); };
  events.onerror = () => {
    if (ended) return;
    badge.textContent = "connection lost";
    badge.className = "badge lost";
    root.dataset.state = "lost";
  };
  for (const [name, handle] of Object.entries(handlers)) {
    events.addEventListener(name, (event) => { received += event.data.length; handle(JSON.parse(event.data)); });
  }

  setInterval(() => { if (scene) scene.update(); }, 150);
  setInterval(() => { curves.draw(); showTraffic(); if (scene) scene.refresh(); }, 1000);
  showControl();
})();
