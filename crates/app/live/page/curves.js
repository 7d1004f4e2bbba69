// The curves of a training run, next to its current policy.

const $ = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";
// Size of a diagram in its own units, and its margins: left, right, top, bottom.
const [W, H] = [320, 150];
const [L, R, T, B] = [40, 8, 8, 18];

const short = (x) => {
  const size = Math.abs(x);
  if (size >= 10000) return `${Math.round(x / 1000)}k`;
  return size >= 100 || x === 0 ? x.toFixed(0) : size >= 1 ? x.toFixed(1) : x.toFixed(size >= 0.095 ? 2 : 3);
};

const time = (s) => {
  const minutes = Math.round(s / 60);
  return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
};

// A round number that is not below x.
function round(x) {
  if (!(x > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(x));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((k) => k * ten >= x * 0.999) * ten;
}

function node(parent, kind, values, words) {
  const made = parent.appendChild(document.createElementNS(SVG, kind));
  for (const [name, value] of Object.entries(values)) made.setAttribute(name, value);
  if (words !== undefined) made.textContent = words;
  return made;
}

// The published run is a pale line, and reaches as far ahead as the run has come.
function diagram({ title, unit, points, published }) {
  const box = document.createElement("figure");
  const head = box.appendChild(document.createElement("figcaption"));
  head.appendChild(document.createElement("span")).textContent = title;
  const last = points[points.length - 1];
  head.appendChild(document.createElement("b")).textContent = last ? short(last[1]) : "–";
  head.appendChild(document.createElement("span")).textContent = unit;
  const svg = node(box, "svg", { viewBox: `0 0 ${W} ${H}`, role: "img" });
  node(svg, "title", {}, title);
  const own = last ? last[0] : 1;
  const pale = published.filter((p) => p[0] <= 2 * own + 1);
  const values = points.concat(pale).map((p) => p[1]);
  const high = round(Math.max(0, ...values));
  const low = values.some((v) => v < 0) ? -round(-Math.min(...values)) : 0;
  const far = Math.max(own, ...pale.map((p) => p[0]));
  const x = (v) => L + ((W - L - R) * v) / (far || 1);
  const y = (v) => T + ((H - T - B) * (high - v)) / (high - low || 1);
  for (const v of [low, (low + high) / 2, high]) {
    node(svg, "path", { class: "grid", d: `M${L} ${y(v)}H${W - R}` });
    node(svg, "text", { x: L - 5, y: y(v) + 3.5, "text-anchor": "end" }, short(v));
  }
  node(svg, "text", { x: L, y: H - 4 }, "0");
  node(svg, "text", { x: W - R, y: H - 4, "text-anchor": "end" }, `${far.toFixed(far < 10 ? 2 : 0)} million samples`);
  const line = (kind, of) => {
    if (of.length > 1) node(svg, "path", { class: kind, d: `M${of.map(([a, b]) => `${x(a).toFixed(1)} ${y(b).toFixed(1)}`).join("L")}` });
  };
  line("pale", pale);
  line("line", points);
  if (last) node(svg, "circle", { class: "dot", cx: x(last[0]), cy: y(last[1]), r: 3 });
  return box;
}

// Another program may show no training.
export function hideCurves() {
  document.body.classList.remove("training", "waiting");
  $("curves").hidden = true;
}

// Shows the program's message; the page becomes that of a training run.
export function showCurves(told) {
  document.body.classList.add("training");
  document.body.classList.toggle("waiting", told.playing === null && !window.paid?.view.scene);
  $("curves").hidden = false;
  const stage = { stage1: "Stage I: it learns to follow", stage2: "Stage II: it learns to kick" }[told.stage] || told.stage || "Training";
  const of = told.iterations ? ` of ${told.iterations}` : "";
  $("stage").textContent = stage;
  $("progress").textContent = told.iteration
    ? `iteration ${told.iteration}${of} · ${(1e-6 * told.samples).toFixed(2)} million samples · ${time(told.elapsed_s)}, ${time(told.eta_s)} to go`
    : "the first iteration is not over yet";
  $("standing").textContent = told.standing ?? "";
  $("policy").textContent = told.playing === null ? "The first policy will appear with the first checkpoint." : `The policy after iteration ${told.playing}.`;
  $("diagrams").replaceChildren(...told.curves.map(diagram));
}
