// Unpacks the numbers of the page. Places are whole multiples of `step` from `center`, in mm; so are deviations.
function bytesOf(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

const wordsOf = text => new Uint16Array(bytesOf(text).buffer);
const signedOf = text => new Int16Array(bytesOf(text).buffer);

function readMap(text) {
  const json = JSON.parse(text);
  const map = {
    tolerance: json.tolerance, center: json.center, step: json.step, deviationStep: json.deviationStep,
    spacing: json.spacing / json.step, views: json.views, features: json.features, findings: json.findings,
    ramp: bytesOf(json.ramp),
    surface: {
      places: signedOf(json.surface.places), normals: new Int8Array(bytesOf(json.surface.normals).buffer),
      features: wordsOf(json.surface.features), triangles: wordsOf(json.surface.triangles), edges: wordsOf(json.surface.edges),
    },
    points: { places: signedOf(json.points.places), features: wordsOf(json.points.features) },
    aside: signedOf(json.aside),
  };
  map.surface.count = map.surface.places.length / 4;
  map.points.count = map.points.places.length / 4;
  // Edges of a free form of many facets would hide what is drawn on them.
  map.drawEdges = map.surface.edges.length * 6 < map.surface.triangles.length * 4;
  map.radius = 1;
  map.featureBalls = map.features.map(() => null);
  measureExtents(map);
  return map;
}

// The ball around everything, and one around each feature.
function measureExtents(map) {
  const places = map.surface.places, boxes = map.features.map(() => null);
  const all = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
  const add = (box, i) => {
    for (let k = 0; k < 3; k++) {
      box[k] = Math.min(box[k], places[4 * i + k]);
      box[k + 3] = Math.max(box[k + 3], places[4 * i + k]);
    }
  };
  for (let i = 0; i < map.surface.count; i++) {
    add(all, i);
    const feature = map.surface.features[i] - 1;
    if (feature < 0) continue;
    if (!boxes[feature]) boxes[feature] = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
    add(boxes[feature], i);
  }
  const ball = box => ({
    center: [0, 1, 2].map(k => (box[k] + box[k + 3]) / 2),
    radius: Math.max(1, Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]) / 2),
  });
  map.ball = ball(all);
  map.radius = map.ball.radius;
  map.featureBalls = boxes.map(box => box && ball(box));
}

const toMm = (map, p) => p.map((v, k) => map.center[k] + v * map.step);
const fromMm = (map, p) => p.map((v, k) => (v - map.center[k]) / map.step);
