// The map's behaviour: turning, reading, choosing features, flying to findings.
const byId = id => document.getElementById(id);
const viewer = byId("viewer"), stage = byId("stage"), readout = byId("readout"), hint = byId("hint"), marks = byId("marks");
let canvas = byId("canvas");
// One map for each artifact, unpacked when it is first looked at.
const packed = [...document.querySelectorAll(".map-data")], maps = [readMap(packed[0].textContent)];
let map = maps[0], shown = 0;
const camera = new Camera(map), root = document.documentElement;
const state = { mode: "surface", feature: -1, only: false, aside: false, pins: true, finding: -1, magnify: 1, dark: false };
const still = matchMedia("(prefers-reduced-motion: reduce)");
let renderer = null, waiting = false, flight = 0, frames = 0, projection = null;

viewer.hidden = false;

function makeRenderer() {
  renderer = makeGlRenderer(canvas, map);
  if (renderer) {
    const own = canvas;
    own.addEventListener("webglcontextlost", () => {
      if (canvas !== own) return;
      useFreshCanvas();
      renderer = makeSoftRenderer(canvas, map);
      redraw();
    });
  } else {
    // A canvas that was asked for WebGL may refuse anything else.
    useFreshCanvas();
    renderer = makeSoftRenderer(canvas, map);
  }
}

function useFreshCanvas() {
  const fresh = canvas.cloneNode();
  canvas.replaceWith(fresh);
  canvas = fresh;
}

function redraw() {
  projection = null;
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(draw);
}

function draw() {
  waiting = false;
  if (!renderer) return;
  // Without a graphics processor a pixel costs: no finer than the page.
  const ratio = renderer.kind === "webgl" ? Math.min(2, devicePixelRatio || 1) : 1;
  const width = Math.max(1, Math.round(stage.clientWidth * ratio)), height = Math.max(1, Math.round(stage.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) canvas.width = width, canvas.height = height;
  renderer.draw(state, camera, ratio);
  placeMarks();
  canvas.dataset.renderer = renderer.kind;
  canvas.dataset.frames = ++frames;
  canvas.dataset.view = camera.turn.flat().concat(camera.target, camera.half).map(v => v.toFixed(4)).join(" ");
  canvas.dataset.feature = state.feature;
  canvas.dataset.artifact = packed[shown].dataset.file;
}

// ---- Which artifact

function fillFeatures() {
  const all = new Option("all features", "-1");
  byId("feature").replaceChildren(all, ...map.features.map((name, index) => new Option(name, String(index))));
  for (const part of document.querySelectorAll("[data-map]")) part.hidden = Number(part.dataset.map) !== shown;
}

// The part is seen as before, though every map counts places in units of its own.
function openMap(index) {
  if (index === shown) return;
  cancelAnimationFrame(flight);
  flight = 0;
  const target = toMm(map, camera.target), half = camera.half * map.step;
  map = maps[index] = maps[index] || readMap(packed[index].textContent);
  shown = index;
  camera.map = map;
  camera.target = fromMm(map, target);
  camera.half = half / map.step;
  state.finding = -1;
  const released = renderer;
  useFreshCanvas();
  if (released) released.release();
  makeRenderer();
  fillFeatures();
  makeMarks();
  if (byId("artifact")) byId("artifact").value = String(index);
  choose(-1, false);
  tell("The map shows " + packed[index].dataset.file + ".");
}

// ---- Reading

function projected() {
  if (projection) return projection;
  const width = stage.clientWidth, height = stage.clientHeight;
  const of = (places, count) => {
    const result = new Float32Array(3 * count), s = height / 2 / camera.scale(width, height), [x, y, z] = camera.turn, t = camera.target;
    for (let i = 0; i < count; i++) {
      const p = places[4 * i] - t[0], q = places[4 * i + 1] - t[1], r = places[4 * i + 2] - t[2];
      result[3 * i] = width / 2 + s * (x[0] * p + x[1] * q + x[2] * r);
      result[3 * i + 1] = height / 2 - s * (y[0] * p + y[1] * q + y[2] * r);
      result[3 * i + 2] = z[0] * p + z[1] * q + z[2] * r;
    }
    return result;
  };
  projection = { surface: of(map.surface.places, map.surface.count), points: of(map.points.places, map.points.count) };
  return projection;
}

function pickSurface(x, y) {
  const s = projected().surface, { triangles, places, normals, features } = map.surface;
  let best = null;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    const ax = s[3 * a], ay = s[3 * a + 1], bx = s[3 * b], by = s[3 * b + 1], cx = s[3 * c], cy = s[3 * c + 1];
    if ((ax < x && bx < x && cx < x) || (ax > x && bx > x && cx > x) || (ay < y && by < y && cy < y) || (ay > y && by > y && cy > y)) continue;
    if (state.only && state.feature >= 0 && features[a] - 1 !== state.feature) continue;
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if (area === 0) continue;
    const u = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area, v = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area, w = 1 - u - v;
    if (u < 0 || v < 0 || w < 0) continue;
    const depth = w * s[3 * a + 2] + u * s[3 * b + 2] + v * s[3 * c + 2];
    if (best && depth <= best.depth) continue;
    const mix = k => w * places[4 * a + k] + u * places[4 * b + k] + v * places[4 * c + k];
    const nearest = w >= u && w >= v ? a : u >= v ? b : c;
    best = { depth, place: [mix(0), mix(1), mix(2)], deviation: mix(3) * map.deviationStep, feature: features[a] - 1, support: normals[4 * nearest + 3] };
  }
  return best;
}

function pickPoint(x, y, deepest) {
  const s = projected().points, { places, features } = map.points;
  const reach = Math.max(6, map.spacing * stage.clientHeight / 2 / camera.scale(stage.clientWidth, stage.clientHeight));
  let best = -1;
  for (let i = 0; i < map.points.count; i++) {
    const dx = s[3 * i] - x, dy = s[3 * i + 1] - y;
    if (dx * dx + dy * dy > reach * reach || s[3 * i + 2] < deepest) continue;
    if (state.only && state.feature >= 0 && features[i] - 1 !== state.feature) continue;
    if (best < 0 || s[3 * i + 2] > s[3 * best + 2]) best = i;
  }
  if (best < 0) return null;
  return { depth: s[3 * best + 2], place: [0, 1, 2].map(k => places[4 * best + k]), deviation: places[4 * best + 3] * map.deviationStep,
    feature: features[best] - 1, support: 0, point: true };
}

function pick(x, y) {
  const surface = state.mode === "points" ? null : pickSurface(x, y);
  if (state.mode === "surface") return surface;
  return pickPoint(x, y, surface ? surface.depth - 0.03 * map.radius : -Infinity) || surface;
}

const digits = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(map.tolerance))));
const signed = mm => (Math.abs(mm) < 0.5 * 10 ** -digits ? "" : mm < 0 ? "\u2212" : "+") + Math.abs(mm).toFixed(digits);

function wordsOfHit(hit) {
  const place = "(" + toMm(map, hit.place).map(v => v.toFixed(2)).join(", ") + ")";
  const name = hit.feature >= 0 ? map.features[hit.feature] : "no feature";
  const value = hit.support === 1 ? "not scanned" : hit.support === 2 ? "contradicted by the scan"
    : signed(hit.deviation) + " mm" + (Math.abs(hit.deviation) > map.tolerance ? ", beyond the tolerance" : "");
  return { value, name, place };
}

let telling = 0;
function tell(text) {
  // One message when the pointer rests, not hundreds while it moves.
  clearTimeout(telling);
  telling = setTimeout(() => { readout.textContent = text; }, 150);
}

function showHit(hit, x, y) {
  hint.hidden = !hit;
  if (!hit) return tell("No surface here.");
  const words = wordsOfHit(hit), strong = document.createElement("b");
  strong.textContent = words.value;
  hint.replaceChildren(strong, document.createElement("br"), words.name, document.createElement("br"), words.place + " mm");
  const left = x + 18 + hint.offsetWidth > stage.clientWidth ? x - 14 - hint.offsetWidth : x + 18;
  hint.style.left = Math.max(0, left) + "px";
  hint.style.top = Math.max(0, Math.min(y + 14, stage.clientHeight - hint.offsetHeight)) + "px";
  tell(words.value + " \u00b7 " + words.name + " \u00b7 at " + words.place + " mm" + (hit.point ? " (scanned point)" : ""));
}

// ---- Moving

const aspect = () => stage.clientWidth / Math.max(1, stage.clientHeight);

function fly(goal) {
  cancelAnimationFrame(flight);
  hint.hidden = true;
  const from = { turn: camera.turn, target: camera.target.slice(), half: camera.half }, begin = performance.now();
  const step = now => {
    const share = still.matches ? 1 : Math.min(1, (now - begin) / 450);
    camera.between(from, goal, share >= 1 ? 1 : share * share * (3 - 2 * share));
    redraw();
    flight = share < 1 ? requestAnimationFrame(step) : 0;
  };
  step(begin);
}

function showView(index) {
  fly(camera.goal(turnTo(map.views[index].eye, map.views[index].up), state.feature, aspect()));
  tell("View " + map.views[index].words + ".");
}

function choose(feature, moves) {
  state.feature = feature;
  byId("feature").value = String(feature);
  for (const button of document.querySelectorAll(".pick[data-feature]")) {
    const mine = shown === 0 && Number(button.dataset.feature) === feature;  // the tables speak of the first artifact
    button.setAttribute("aria-pressed", String(mine));
    button.closest("tr").classList.toggle("selected", mine);
  }
  if (moves) {
    const goal = camera.goal(camera.turn, feature, aspect());
    goal.half = Math.max(goal.half * (feature >= 0 ? 1.3 : 1), 0.3 * map.radius);
    fly(goal);
  }
  tell(feature >= 0 ? "Feature " + map.features[feature] + " is shown alone." : "All features are shown.");
  redraw();
}

// The side of the surface from which a place can be seen best.
function bestEye(place) {
  const { places, normals } = map.surface;
  let best = 0, least = Infinity;
  for (let i = 0; i < map.surface.count; i++) {
    const d = (places[4 * i] - place[0]) ** 2 + (places[4 * i + 1] - place[1]) ** 2 + (places[4 * i + 2] - place[2]) ** 2;
    if (d < least) least = d, best = i;
  }
  return unit([normals[4 * best] || 0, normals[4 * best + 1] || 0, normals[4 * best + 2] || 1e-3]);
}

function visit(index) {
  const finding = map.findings[index], place = fromMm(map, finding.place), normal = bestEye(place);
  state.finding = index;
  const eye = unit(normal.map((v, k) => v + 0.35 * camera.up[k] + 0.2 * camera.turn[0][k]));
  const up = Math.abs(dot(eye, camera.up)) > 0.97 ? camera.turn[1] : camera.up;
  fly({ turn: turnTo(eye, up), target: place, half: Math.min(map.radius, Math.max(1.6 * finding.extent / map.step, 0.12 * map.radius)) });
  tell("Finding " + (index + 1) + ": " + finding.text.replaceAll("+-", "\u00b1"));
  redraw();
}

let pinned = [];
function makeMarks() {
  marks.replaceChildren();
  pinned = map.findings.slice(0, 30).map((finding, index) => {
    const mark = document.createElement("span");
    mark.className = "mark";
    mark.textContent = String(index + 1);
    marks.append(mark);
    return { mark, place: fromMm(map, finding.place), index };
  });
}

function placeMarks() {
  marks.hidden = !state.pins;
  if (!state.pins) return;
  for (const pin of pinned) {
    const [x, y, depth] = camera.project(pin.place, stage.clientWidth, stage.clientHeight);
    const front = waiting || flight ? null : pickSurface(x, y);
    pin.mark.style.left = x + "px";
    pin.mark.style.top = y + "px";
    pin.mark.classList.toggle("behind", front !== null && front.depth > depth + 0.03 * map.radius);
    pin.mark.classList.toggle("current", pin.index === state.finding);
  }
}

// ---- Events

let drag = null;
const at = event => { const box = stage.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
const fingers = new Map();
stage.addEventListener("pointerdown", event => {
  fingers.set(event.pointerId, at(event));
  drag = { last: at(event), moved: 0, pans: event.shiftKey || event.button > 0, apart: 0 };
  if (event.pointerId !== undefined) try { stage.setPointerCapture(event.pointerId); } catch { /* a synthetic pointer */ }
  hint.hidden = true;
});
stage.addEventListener("pointermove", event => {
  const [x, y] = at(event);
  if (!drag) return showHit(pick(x, y), x, y);
  fingers.set(event.pointerId, [x, y]);
  const mm = camera.scale(stage.clientWidth, stage.clientHeight) * 2 / stage.clientHeight;
  if (fingers.size === 2) {
    const [p, q] = [...fingers.values()], apart = Math.hypot(p[0] - q[0], p[1] - q[1]), middle = [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
    if (drag.apart) {
      camera.zoom(apart / drag.apart);
      camera.pan((middle[0] - drag.last[0]) * mm, -(middle[1] - drag.last[1]) * mm);
    }
    drag.apart = apart, drag.last = middle, drag.moved = 99;
    return redraw();
  }
  const dx = x - drag.last[0], dy = y - drag.last[1];
  drag.moved += Math.abs(dx) + Math.abs(dy);
  drag.last = [x, y];
  if (drag.pans) camera.pan(dx * mm, -dy * mm);
  else camera.orbit(dx * 0.009, dy * 0.009);
  redraw();
});
const drop = event => {
  fingers.delete(event.pointerId);
  if (fingers.size) return;
  const [x, y] = at(event);
  if (drag && drag.moved < 4 && event.type === "pointerup" && !drag.pans) {
    const hit = pick(x, y);
    choose(hit && hit.feature !== state.feature ? hit.feature : -1, false);
    showHit(hit, x, y);
  }
  drag = null;
};
stage.addEventListener("pointerup", drop);
stage.addEventListener("pointercancel", drop);
stage.addEventListener("pointerleave", () => { hint.hidden = true; });
stage.addEventListener("contextmenu", event => event.preventDefault());
stage.addEventListener("wheel", event => {
  event.preventDefault();
  camera.zoom(Math.exp(-event.deltaY * 0.0012));
  redraw();
}, { passive: false });

stage.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  const view = Number(event.key) - 1;
  if (step && event.shiftKey) camera.pan(step[0] * 0.06 * camera.half, -step[1] * 0.06 * camera.half);
  else if (step) camera.orbit(step[0] * 0.12, step[1] * 0.12);
  else if (event.key === "+" || event.key === "=") camera.zoom(1.15);
  else if (event.key === "-") camera.zoom(1 / 1.15);
  else if (event.key === "0" || event.key === "Home") choose(-1, false), camera.reset(aspect());
  else if (event.key === "Escape") state.finding = -1, choose(-1, true);
  else if (event.key === "Enter" || event.key === " ") {
    const x = stage.clientWidth / 2, y = stage.clientHeight / 2;
    showHit(pick(x, y), x, y);
  } else if (view >= 0 && view < map.views.length) showView(view);
  else return;
  event.preventDefault();
  redraw();
});

for (const input of document.querySelectorAll("input[name=mode]"))
  input.addEventListener("change", () => { if (input.checked) state.mode = input.value; redraw(); });
byId("feature").addEventListener("change", event => choose(Number(event.target.value), true));
for (const name of ["only", "aside", "pins"])
  byId(name).addEventListener("change", event => { state[name] = event.target.checked; redraw(); });
byId("magnify").addEventListener("change", event => {
  state.magnify = Number(event.target.value);
  // The scale says what its colours mean now; its histogram belongs to the plain one.
  const places = Math.max(0, Math.min(8, 3 - Math.floor(Math.log10(map.tolerance / state.magnify))));
  for (const tick of document.querySelectorAll(".scale [data-share]")) {
    const share = Number(tick.dataset.share), mm = share * map.tolerance / state.magnify;
    tick.textContent = share === 0 ? "0" : (share < 0 ? "\u2212" : "+") + Number(Math.abs(mm).toFixed(places)) +
      (Math.abs(share) === 1 ? state.magnify === 1 ? " T" : " T/" + state.magnify : "");
  }
  for (const bars of document.querySelectorAll(".scale .bars")) bars.style.visibility = state.magnify === 1 ? "" : "hidden";
  tell("Colours for " + (state.magnify === 1 ? "the tolerance T." : "T/" + state.magnify + "."));
  redraw();
});
byId("closer").addEventListener("click", () => { camera.zoom(1.25); redraw(); });
byId("farther").addEventListener("click", () => { camera.zoom(0.8); redraw(); });
map.views.forEach((view, index) => {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = view.name;
  button.setAttribute("aria-label", "View " + view.words);
  button.addEventListener("click", () => showView(index));
  byId("sides").append(button);
});
for (const button of document.querySelectorAll(".pick"))
  button.addEventListener("click", () => {
    openMap(0);
    if (button.dataset.finding !== undefined) visit(Number(button.dataset.finding));
    else choose(Number(button.dataset.feature) === state.feature ? -1 : Number(button.dataset.feature), true);
    byId("map").scrollIntoView({ behavior: still.matches ? "auto" : "smooth" });
  });

if (byId("artifact")) byId("artifact").addEventListener("change", event => openMap(Number(event.target.value)));

// The background is the page's.
function followScheme() {
  state.dark = getComputedStyle(root).colorScheme === "dark";
  redraw();
}
root.addEventListener("schemechange", followScheme);
followScheme();

fillFeatures();
makeMarks();
makeRenderer();
camera.reset(aspect());
new ResizeObserver(redraw).observe(stage);
redraw();
