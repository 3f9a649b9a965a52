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
    points: { places: signedOf(json.points.places), normals: new Int8Array(bytesOf(json.points.normals).buffer), features: wordsOf(json.points.features) },
    aside: signedOf(json.aside),
  };
  map.surface.count = map.surface.places.length / 4;
  map.points.count = map.points.places.length / 4;
  // Edges of a free form of many facets would hide what is drawn on them.
  map.drawEdges = map.surface.edges.length * 6 < map.surface.triangles.length * 4;
  measureExtent(map);
  return map;
}

// The ball around everything.
function measureExtent(map) {
  const places = map.surface.places, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < map.surface.count; i++)
    for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k], places[4 * i + k]);
      high[k] = Math.max(high[k], places[4 * i + k]);
    }
  const radius = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2;
  map.ball = { center: [0, 1, 2].map(k => (low[k] + high[k]) / 2), radius };
  map.radius = Math.max(1, radius);
}

const darkGround = [44, 52, 61];  // --ground on a dark screen: the darkest colours of the scale still stand out
const toMm = (map, p) => p.map((v, k) => map.center[k] + v * map.step);
const fromMm = (map, p) => p.map((v, k) => (v - map.center[k]) / map.step);
