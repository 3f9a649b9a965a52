// Draws the map without WebGL: a depth buffer of our own on a plain canvas.
function makeSoftRenderer(canvas, map) {
  const pen = canvas.getContext("2d");
  if (!pen) return null;
  let image = null, colors = null, depths = null;
  const screen = new Float32Array(3 * map.surface.count), light = new Float32Array(map.surface.count);
  const key = unit([-0.45, 0.65, 0.9]), fill = unit([0.8, -0.2, 0.5]);

  function put(at, depth, r, g, b) {
    depths[at] = depth;
    colors[at] = 0xff000000 | b << 16 | g << 8 | r;
  }

  function lightOf(normals, i, camera) {
    const n = [normals[4 * i] / 127, normals[4 * i + 1] / 127, normals[4 * i + 2] / 127];
    const side = dot(camera.turn[2], n) < 0 ? -1 : 1, f = camera.turn.map(row => side * dot(row, n));
    return 0.62 + 0.32 * Math.max(0, dot(f, key)) + 0.1 * Math.max(0, dot(f, fill));
  }

  function projectSurface(camera, width, height) {
    const places = map.surface.places, normals = map.surface.normals;
    for (let i = 0; i < map.surface.count; i++) {
      const p = camera.project([places[4 * i], places[4 * i + 1], places[4 * i + 2]], width, height);
      screen.set(p, 3 * i);
      light[i] = lightOf(normals, i, camera);
    }
  }

  function drawSurface(state, width, height) {
    const { triangles, places, normals, features } = map.surface, perTolerance = state.magnify * map.deviationStep / map.tolerance;
    for (let t = 0; t < triangles.length; t += 3) {
      const a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
      const mine = state.feature < 0 || features[a] - 1 === state.feature;
      if (!mine && state.only) continue;
      const ax = screen[3 * a], ay = screen[3 * a + 1], bx = screen[3 * b], by = screen[3 * b + 1], cx = screen[3 * c], cy = screen[3 * c + 1];
      const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
      if (area === 0) continue;
      const left = Math.max(0, Math.ceil(Math.min(ax, bx, cx) - 0.5)), right = Math.min(width - 1, Math.floor(Math.max(ax, bx, cx) - 0.5));
      const top = Math.max(0, Math.ceil(Math.min(ay, by, cy) - 0.5)), bottom = Math.min(height - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
      for (let y = top; y <= bottom; y++)
        for (let x = left; x <= right; x++) {
          const u = ((x + 0.5 - ax) * (cy - ay) - (cx - ax) * (y + 0.5 - ay)) / area;
          const v = ((bx - ax) * (y + 0.5 - ay) - (x + 0.5 - ax) * (by - ay)) / area, w = 1 - u - v;
          if (u < -1e-6 || v < -1e-6 || w < -1e-6) continue;
          const depth = w * screen[3 * a + 2] + u * screen[3 * b + 2] + v * screen[3 * c + 2], at = y * width + x;
          if (depth <= depths[at]) continue;
          const support = [normals[4 * a + 3], normals[4 * b + 3], normals[4 * c + 3]][w >= u && w >= v ? 0 : u >= v ? 1 : 2];
          const deviation = (w * places[4 * a + 3] + u * places[4 * b + 3] + v * places[4 * c + 3]) * perTolerance;
          const k = 3 * Math.min(255, Math.max(0, Math.floor((0.5 + 0.25 * deviation) * 256))), stripe = (x + y) % 8 < 3;
          let r = map.ramp[k], g = map.ramp[k + 1], bl = map.ramp[k + 2];
          if (state.mode === "both") r = 204, g = 209, bl = 214;
          if (support === 2) [r, g, bl] = stripe ? [150, 0, 110] : [255, 214, 240];
          else if (support === 1) [r, g, bl] = stripe ? [176, 176, 170] : [247, 246, 240];
          if (!mine) [r, g, bl] = [r, g, bl].map((v, k) => v + 0.88 * ((state.dark ? [56, 64, 71] : [237, 240, 242])[k] - v));
          const l = w * light[a] + u * light[b] + v * light[c];
          put(at, depth, r * l, g * l, bl * l);
        }
    }
  }

  function drawEdges(state, width, height) {
    const edges = map.surface.edges, shade = state.feature < 0 ? 45 : state.dark ? 110 : 190, bias = 0.004 * map.radius;
    for (let e = 0; e < edges.length; e += 2) {
      const a = 3 * edges[e], b = 3 * edges[e + 1], dx = screen[b] - screen[a], dy = screen[b + 1] - screen[a + 1];
      const steps = Math.min(4000, Math.ceil(Math.max(Math.abs(dx), Math.abs(dy))));
      for (let k = 0; k <= steps; k++) {
        const s = steps ? k / steps : 0, x = Math.floor(screen[a] + s * dx), y = Math.floor(screen[a + 1] + s * dy);
        if (x < 0 || y < 0 || x >= width || y >= height) continue;
        const depth = screen[a + 2] + s * (screen[b + 2] - screen[a + 2]) + bias, at = y * width + x;
        if (depth > depths[at]) put(at, depth, shade, shade + 5, shade + 10);
      }
    }
  }

  function drawPoints(places, features, count, camera, state, radius, bias, color, width, height) {
    const perTolerance = state.magnify * map.deviationStep / map.tolerance;
    for (let i = 0; i < count; i++) {
      const mine = state.feature < 0 || !features || features[i] - 1 === state.feature;
      if (!mine && state.only) continue;
      const p = camera.project([places[4 * i], places[4 * i + 1], places[4 * i + 2]], width, height), depth = p[2] + bias;
      const k = 3 * Math.min(255, Math.max(0, Math.floor((0.5 + 0.25 * places[4 * i + 3] * perTolerance) * 256)));
      const l = color ? 1 : lightOf(map.points.normals, i, camera);
      const [r, g, b] = (color || (mine ? [map.ramp[k], map.ramp[k + 1], map.ramp[k + 2]] : state.dark ? [69, 77, 87] : [220, 222, 225])).map(v => v * l);
      for (let y = Math.round(p[1]) - radius; y <= Math.round(p[1]) + radius; y++)
        for (let x = Math.round(p[0]) - radius; x <= Math.round(p[0]) + radius; x++)
          if (x >= 0 && y >= 0 && x < width && y < height && depth > depths[y * width + x]) put(y * width + x, depth, r, g, b);
    }
  }

  return {
    kind: "canvas",
    release() {},
    draw(state, camera) {
      const width = canvas.width, height = canvas.height;
      if (!image || image.width !== width || image.height !== height) {
        image = pen.createImageData(width, height);
        colors = new Uint32Array(image.data.buffer);
        depths = new Float32Array(width * height);
      }
      const [r, g, b] = state.dark ? darkGround : [255, 255, 255];
      colors.fill(0xff000000 | b << 16 | g << 8 | r);
      depths.fill(-Infinity);
      if (state.mode !== "points") {
        projectSurface(camera, width, height);
        drawSurface(state, width, height);
        if (map.drawEdges) drawEdges(state, width, height);
      }
      const both = state.mode === "both", bias = both ? 0.02 * map.radius : 0;
      const radius = Math.min(4, Math.max(1, Math.round((both ? 0.4 : 0.8) * map.spacing * height / 2 / camera.scale(width, height))));
      if (state.mode !== "surface")
        drawPoints(map.points.places, map.points.features, map.points.count, camera, state, radius, bias, null, width, height);
      if (state.aside) drawPoints(map.aside, null, map.aside.length / 4, camera, state, 1, 0.02 * map.radius, state.dark ? [184, 122, 235] : [120, 60, 160], width, height);
      pen.putImageData(image, 0, 0);
    },
  };
}
