// Draws the map by WebGL. Returns null where the browser has none.
const commonShader = `
precision highp float;
uniform mat3 turn;
uniform vec3 target, scale;
vec4 seen(vec3 place, float nearer) {
  vec3 p = turn * (place - target);
  return vec4(p.x * scale.x, p.y * scale.y, -p.z * scale.z - nearer, 1.0);
}
`;

const surfaceVertexShader = commonShader + `
attribute vec4 place, normal;
attribute float feature;
uniform float perTolerance, chosen;
varying float deviation, mine;
varying vec2 state;
varying vec3 facing;
void main() {
  gl_Position = seen(place.xyz, 0.0);
  deviation = place.w * perTolerance;
  float support = floor(normal.w * 127.0 + 0.5);
  state = vec2(support == 1.0 ? 1.0 : 0.0, support == 2.0 ? 1.0 : 0.0);
  mine = chosen < 0.0 || abs(feature - 1.0 - chosen) < 0.5 ? 1.0 : 0.0;
  facing = turn * normal.xyz;
}
`;

const lightShader = `
precision highp float;
float light(vec3 facing) {
  vec3 n = normalize(facing);
  if (n.z < 0.0) n = -n;
  return 0.62 + 0.32 * max(0.0, dot(n, normalize(vec3(-0.45, 0.65, 0.9)))) + 0.10 * max(0.0, dot(n, normalize(vec3(0.8, -0.2, 0.5))));
}
`;

const surfaceFragmentShader = lightShader + `
uniform sampler2D ramp;
uniform float plain, only, grain, dark;
varying float deviation, mine;
varying vec2 state;
varying vec3 facing;
void main() {
  if (only > 0.5 && mine < 0.5) discard;
  vec3 color = texture2D(ramp, vec2(clamp(0.5 + 0.25 * deviation, 0.002, 0.998), 0.5)).rgb;
  if (plain > 0.5) color = vec3(0.80, 0.82, 0.84);
  bool stripe = mod(gl_FragCoord.x + gl_FragCoord.y, 8.0 * grain) < 2.5 * grain;
  if (state.y > 0.5) color = stripe ? vec3(0.59, 0.0, 0.43) : vec3(1.0, 0.84, 0.94);
  else if (state.x > 0.5) color = stripe ? vec3(0.69, 0.69, 0.67) : vec3(0.97, 0.965, 0.94);
  if (mine < 0.5) color = mix(color, dark > 0.5 ? vec3(0.22, 0.25, 0.28) : vec3(0.93, 0.94, 0.95), 0.88);
  gl_FragColor = vec4(color * light(facing), 1.0);
}
`;

const pointVertexShader = commonShader + `
attribute vec4 place, normal;
attribute float feature;
uniform float perTolerance, chosen, size, nearer, one;
varying float deviation, mine;
varying vec3 facing;
void main() {
  gl_Position = seen(place.xyz, nearer);
  facing = one > 0.5 ? vec3(0.0, 0.0, 1.0) : turn * normal.xyz;
  deviation = place.w * perTolerance;
  mine = chosen < 0.0 || abs(feature - 1.0 - chosen) < 0.5 ? 1.0 : 0.0;
  gl_PointSize = mine > 0.5 || one > 0.5 ? size : max(1.5, 0.5 * size);
}
`;

const pointFragmentShader = lightShader + `
uniform sampler2D ramp;
uniform float only, one, dark;
varying float deviation, mine;
varying vec3 facing;
void main() {
  vec2 d = gl_PointCoord - 0.5;
  if (dot(d, d) > 0.25 || (only > 0.5 && mine < 0.5 && one < 0.5)) discard;
  vec3 color = texture2D(ramp, vec2(clamp(0.5 + 0.25 * deviation, 0.002, 0.998), 0.5)).rgb;
  if (mine < 0.5) color = dark > 0.5 ? vec3(0.27, 0.30, 0.34) : vec3(0.86, 0.87, 0.88);
  if (one > 0.5) color = dark > 0.5 ? vec3(0.72, 0.48, 0.92) : vec3(0.47, 0.235, 0.63);
  gl_FragColor = vec4(color * light(facing), 1.0);
}
`;

const lineVertexShader = commonShader + `
attribute vec4 place;
void main() { gl_Position = seen(place.xyz, 0.002); }
`;

const lineFragmentShader = `
precision highp float;
uniform float faint, dark;
void main() { gl_FragColor = vec4(mix(vec3(0.16, 0.2, 0.24), dark > 0.5 ? vec3(0.42, 0.46, 0.5) : vec3(0.75), faint), 1.0); }
`;

function makeGlRenderer(canvas, map) {
  const gl = canvas.getContext("webgl", { antialias: true, alpha: false });
  if (!gl) return null;
  const compiled = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    return gl.getShaderParameter(shader, gl.COMPILE_STATUS) ? shader : null;
  };
  const linked = (vertex, fragment) => {
    const program = gl.createProgram(), parts = [compiled(gl.VERTEX_SHADER, vertex), compiled(gl.FRAGMENT_SHADER, fragment)];
    if (parts.includes(null)) return null;
    for (const part of parts) gl.attachShader(program, part);
    gl.linkProgram(program);
    return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
  };
  const programs = {
    surface: linked(surfaceVertexShader, surfaceFragmentShader),
    point: linked(pointVertexShader, pointFragmentShader),
    line: linked(lineVertexShader, lineFragmentShader),
  };
  if (!programs.surface || !programs.point || !programs.line) return null;
  const buffer = (data, target = gl.ARRAY_BUFFER) => {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return made;
  };
  const buffers = {
    places: buffer(map.surface.places), normals: buffer(map.surface.normals), features: buffer(map.surface.features),
    points: buffer(map.points.places), pointNormals: buffer(map.points.normals), pointFeatures: buffer(map.points.features), aside: buffer(map.aside),
    triangles: buffer(map.surface.triangles, gl.ELEMENT_ARRAY_BUFFER), edges: buffer(map.surface.edges, gl.ELEMENT_ARRAY_BUFFER),
  };
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, map.ramp);
  for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
    [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, value);
  gl.enable(gl.DEPTH_TEST);

  const attribute = (program, name, data, size, type, normalized) => {
    const place = gl.getAttribLocation(program, name);
    if (place < 0) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, data);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, type, normalized, 0, 0);
  };
  const use = (program, camera, values) => {
    for (let k = 0; k < 4; k++) gl.disableVertexAttribArray(k);
    gl.useProgram(program);
    const at = name => gl.getUniformLocation(program, name);
    const [x, y, z] = camera.turn, half = camera.scale(canvas.width, canvas.height);
    gl.uniformMatrix3fv(at("turn"), false, [x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]]);
    gl.uniform3fv(at("target"), camera.target);
    gl.uniform3f(at("scale"), canvas.height / canvas.width / half, 1 / half, 1 / (8 * map.radius));
    for (const [name, value] of Object.entries(values)) gl.uniform1f(at(name), value);
  };

  return {
    kind: "webgl",
    release() { const context = gl.getExtension("WEBGL_lose_context"); if (context) context.loseContext(); },
    draw(state, camera, ratio) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(...(state.dark ? darkGround : [255, 255, 255]).map(v => v / 255), 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      const perTolerance = state.magnify * map.deviationStep / map.tolerance, only = state.only && state.feature >= 0 ? 1 : 0;
      const shared = { perTolerance, only, chosen: state.feature, dark: state.dark ? 1 : 0 };
      if (state.mode !== "points") {
        use(programs.surface, camera, { ...shared, plain: state.mode === "both" ? 1 : 0, grain: ratio });
        attribute(programs.surface, "place", buffers.places, 4, gl.SHORT, false);
        attribute(programs.surface, "normal", buffers.normals, 4, gl.BYTE, true);
        attribute(programs.surface, "feature", buffers.features, 1, gl.UNSIGNED_SHORT, false);
        gl.enable(gl.POLYGON_OFFSET_FILL);
        gl.polygonOffset(1, 1);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.triangles);
        gl.drawElements(gl.TRIANGLES, map.surface.triangles.length, gl.UNSIGNED_SHORT, 0);
        gl.disable(gl.POLYGON_OFFSET_FILL);
        if (map.drawEdges) {
          use(programs.line, camera, { faint: state.feature >= 0 ? 1 : 0, dark: shared.dark });
          attribute(programs.line, "place", buffers.places, 4, gl.SHORT, false);
          gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.edges);
          gl.drawElements(gl.LINES, map.surface.edges.length, gl.UNSIGNED_SHORT, 0);
        }
      }
      const pixels = canvas.height / 2 / camera.scale(canvas.width, canvas.height);
      const points = (places, features, count, one, factor) => {
        const size = Math.min(14 * ratio, Math.max(2 * ratio, factor * map.spacing * pixels));
        use(programs.point, camera, { ...shared, size, one, nearer: state.mode === "both" || one ? 0.004 : 0 });
        attribute(programs.point, "place", places, 4, gl.SHORT, false);
        if (!one) attribute(programs.point, "normal", buffers.pointNormals, 4, gl.BYTE, true);
        if (!one) attribute(programs.point, "feature", features, 1, gl.UNSIGNED_SHORT, false);
        gl.drawArrays(gl.POINTS, 0, count);
      };
      if (state.mode !== "surface") points(buffers.points, buffers.pointFeatures, map.points.count, 0, state.mode === "both" ? 1.1 : 2);
      if (state.aside && map.aside.length) points(buffers.aside, null, map.aside.length / 4, 1, 1.6);
    },
  };
}
