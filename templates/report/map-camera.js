// An orthographic camera: rows of `turn` are right, up and towards the eye; `half` is half the height of the view.
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = a => { const n = Math.hypot(a[0], a[1], a[2]) || 1; return [a[0] / n, a[1] / n, a[2] / n]; };

function turnTo(eye, up) {
  const z = unit(eye);
  let x = cross(up, z);
  if (Math.hypot(x[0], x[1], x[2]) < 1e-6) x = cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z);
  x = unit(x);
  return [x, cross(z, x), z];
}

// Rows turned about the world's direction `axis`.
function turned(rows, axis, angle) {
  const a = unit(axis), c = Math.cos(angle), s = Math.sin(angle);
  return rows.map(v => {
    const w = cross(a, v), d = dot(a, v) * (1 - c);
    return [0, 1, 2].map(k => c * v[k] + s * w[k] + d * a[k]);
  });
}

function tidied(rows) {
  const z = unit(rows[2]), x = unit(cross(rows[1], z));
  return [x, cross(z, x), z];
}

class Camera {
  constructor(map) {
    this.map = map;
    this.up = unit(map.views[0].up);
    this.reset(1.5);
  }
  reset(aspect) { Object.assign(this, this.goal(turnTo(this.map.views[0].eye, this.map.views[0].up), -1, aspect)); }
  // So that the part, or one feature of it, fills a window of this width to height.
  goal(turn, feature, aspect) {
    const { places, features, count } = this.map.surface, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < count; i++) {
      if (feature >= 0 && features[i] - 1 !== feature) continue;
      for (let k = 0; k < 3; k++) {
        const v = turn[k][0] * places[4 * i] + turn[k][1] * places[4 * i + 1] + turn[k][2] * places[4 * i + 2];
        low[k] = Math.min(low[k], v);
        high[k] = Math.max(high[k], v);
      }
    }
    if (low[0] > high[0]) return { turn, target: this.map.ball.center.slice(), half: this.map.radius };
    const middle = [0, 1, 2].map(k => (low[k] + high[k]) / 2), wide = (high[0] - low[0]) / 2, tall = (high[1] - low[1]) / 2;
    const half = Math.max(tall, wide / Math.max(aspect, 1), aspect < 1 ? tall * aspect : 0, 0.15 * this.map.radius);
    return { turn, target: [0, 1, 2].map(k => turn[0][k] * middle[0] + turn[1][k] * middle[1] + turn[2][k] * middle[2]), half: 1.1 * half };
  }
  // The part's upright stays upright: sideways about it, up and down about the screen's horizontal.
  orbit(dx, dy) {
    const upright = dot(this.turn[1], this.up) >= 0 ? 1 : -1;
    this.turn = turned(this.turn, this.up, -dx * upright);
    this.turn = tidied(turned(this.turn, this.turn[0], -dy));
  }
  pan(dx, dy) { for (let k = 0; k < 3; k++) this.target[k] -= dx * this.turn[0][k] + dy * this.turn[1][k]; }
  zoom(factor) { this.half = Math.min(4 * this.map.radius, Math.max(this.map.radius / 500, this.half / factor)); }
  // Screen place in pixels, and depth: larger is nearer.
  project(p, width, height) {
    const d = [p[0] - this.target[0], p[1] - this.target[1], p[2] - this.target[2]], s = height / 2 / this.scale(width, height);
    return [width / 2 + s * dot(this.turn[0], d), height / 2 - s * dot(this.turn[1], d), dot(this.turn[2], d)];
  }
  // Half the height shown; narrow windows still show the whole width.
  scale(width, height) { return this.half * Math.max(1, height / width); }
  between(from, to, share) {
    const mix = (a, b) => a + (b - a) * share;
    const rows = from.turn.map((row, i) => row.map((v, k) => mix(v, to.turn[i][k])));
    this.turn = share >= 1 ? to.turn : tidied(rows);
    this.target = from.target.map((v, k) => mix(v, to.target[k]));
    this.half = from.half * Math.pow(to.half / from.half, share);
  }
}
