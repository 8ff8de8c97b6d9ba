"use strict";
// Builds the page from its data. When all is drawn the root element says so in data-state, with the
// milliseconds since the page was asked for, and in data-view the number of pixels of the 3-D view
// that show something, or "absent".
(function () {
  const { html } = Highwall;
  const root = document.documentElement;
  window.addEventListener("error", (event) => { root.dataset.error = event.message; });

  const data = JSON.parse(document.getElementById("data").textContent);
  const runs = data.runs, content = document.getElementById("content"), contents = document.getElementById("contents");
  for (const run of runs) run.level = Highwall.levelling(Highwall.get(run, "run/map/up_W"));
  document.getElementById("version").textContent = data.version;
  if (typeof THREE !== "undefined") {
    document.getElementById("licence").textContent = `The 3-D view uses three.js (revision ${THREE.REVISION}), copyright its authors, MIT licence.`;
  }

  content.append(html("h1", {}, runs.map((run) => run.name).join(" and ")));
  content.append(html("p", { class: "note" }, [...new Set(runs.map((run) => run.run.dataset).filter(Boolean))].join(", ")));
  for (const section of Highwall.sections) {
    const drawn = section.draw(runs);
    if (drawn === null) continue;
    const heading = html("h2", { id: "h-" + section.id }, section.title);
    content.append(html("section", { id: section.id, "aria-labelledby": "h-" + section.id }, heading,
      section.note ? html("p", { class: "note" + (section.id === "map3d" ? " screen" : "") }, section.note) : null, drawn));
    contents.append(html("a", { href: "#" + section.id }, section.short));
  }

  const view3d = Highwall.view;
  let view = null;
  try {
    view = view3d.start ? view3d.start() : null;
  } catch (error) {
    root.dataset.error = String(error);
  }
  Highwall.shown = view;
  root.dataset.view = view ? String(view.drawnPixels()) : view3d.state;
  root.dataset.milliseconds = String(Math.round(performance.now()));
  root.dataset.state = "drawn";
})();
