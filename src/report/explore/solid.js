"use strict";

// The deformed bodies in three dimensions: WebGL 2 and no library.

const SOLID_VERTEX = `#version 300 es
in vec3 place;
in float share;
uniform vec3 right, up, near, middle;
uniform vec3 zoom;
out vec3 seen;
out float colored;
void main() {
  vec3 p = place - middle;
  seen = vec3(dot(p, right), dot(p, up), dot(p, near));
  colored = share;
  gl_Position = vec4(seen.xy * zoom.xy, -seen.z * zoom.z, 1.0);
}`;
const SOLID_FRAGMENT = `#version 300 es
precision highp float;
in vec3 seen;
in float colored;
uniform sampler2D palette;
uniform vec4 line;
out vec4 color;
void main() {
  vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
  float light = 0.62 + 0.38 * abs(dot(normal, normalize(vec3(-0.35, 0.45, 0.82))));
  vec3 body = texture(palette, vec2(colored, 0.5)).rgb * light;
  color = line.a > 0.0 ? line : vec4(body, 1.0);
}`;
/** Turn of a body of revolution, of which a quarter is cut out, and of its facets, degrees. */
const SOLID_TURN = { whole: 270, facet: 6 };
const SOLID_START = { azimuth: -62, elevation: 24, zoom: 1 };

/** Triangles, lines and stations of a solid; a station says where x and y of a corner's u and v go. */
function solidShape({ kind, copies, quads, outline, places }) {
  const section = kind !== "surface";
  const count = places.length / (section ? 2 : 3);
  const vertices = { corner: [], x: [], y: [], shift: [] };
  const triangles = [];
  const lines = [];
  const vertex = (corner, x, y, shift) => {
    vertices.corner.push(corner);
    vertices.x.push(x);
    vertices.y.push(y);
    vertices.shift.push(shift);
    return vertices.corner.length - 1;
  };
  const quad = (a, b, c, d) => triangles.push(a, b, c, a, c, d);

  // Edges that one quadrilateral alone has: the outline and the borders of regions, which are other corners.
  const edges = new Map();
  for (let q = 0; q < quads.length; q += 4) {
    for (let k = 0; k < 4; k++) {
      const ends = [quads[q + k], quads[q + (k + 1) % 4]];
      const key = Math.min(...ends) * count + Math.max(...ends);
      edges.set(key, edges.has(key) ? null : ends);
    }
  }
  const borders = [...edges.values()].filter(Boolean);

  function face(x, y, shift) {
    const first = vertices.corner.length;
    for (let corner = 0; corner < count; corner++) vertex(corner, x, y, shift);
    for (let q = 0; q < quads.length; q += 4) quad(...[0, 1, 2, 3].map((k) => first + quads[q + k]));
    if (section) for (const [a, b] of borders) lines.push(first + a, first + b);
  }

  /** What the outline sweeps over from station to station. */
  function sweep(stations) {
    const before = new Map();
    const at = (corner, k) => {
      if (!before.has(corner)) before.set(corner, stations.map((station) => vertex(corner, ...station)));
      return before.get(corner)[k];
    };
    for (let e = 0; e < outline.length; e += 2) {
      const [a, b] = [outline[e], outline[e + 1]];
      for (let k = 1; k < stations.length; k++) quad(at(a, k - 1), at(b, k - 1), at(b, k), at(a, k));
    }
  }

  if (kind === "revolved") {
    const stations = [];
    for (let turn = 0; turn <= SOLID_TURN.whole; turn += SOLID_TURN.facet) {
      const angle = (turn * Math.PI) / 180;
      stations.push([Math.cos(angle), Math.sin(angle), 0]);
    }
    face(...stations[0]);
    face(...stations[stations.length - 1]);
    sweep(stations);
  } else if (kind === "extruded") {
    const depth = Math.max(...places.slice(0, count));
    for (const [x] of copies) {
      face(x, 0, 0);
      sweep([[x, 0, 0], [x, 0, depth]]);
    }
  } else {
    for (const [x, y] of copies) face(x, y, 0);
  }
  return { count, section, vertices, triangles: Uint32Array.from(triangles), lines: Uint32Array.from(lines) };
}

/** Where the vertices of a shape lie, for the places of its corners. */
function solidPlaces({ count, section, vertices }, corners) {
  const places = new Float32Array(3 * vertices.corner.length);
  vertices.corner.forEach((corner, i) => {
    const u = corners[corner];
    const v = section ? u : corners[count + corner];
    places[3 * i] = vertices.x[i] * u;
    places[3 * i + 1] = vertices.y[i] * v + vertices.shift[i];
    places[3 * i + 2] = corners[(section ? 1 : 2) * count + corner];
  });
  return places;
}

/** The program with its buffers; nothing where there is no WebGL 2. */
function solidPainter(canvas, shape) {
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, SOLID_VERTEX], [gl.FRAGMENT_SHADER, SOLID_FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
  gl.useProgram(program);
  const attribute = (name, size) => {
    const buffer = gl.createBuffer();
    const place = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
    return (values) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    };
  };
  const [setPlaces, setShares] = [attribute("place", 3), attribute("share", 1)];
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  const all = new Uint32Array(shape.triangles.length + shape.lines.length);
  all.set(shape.triangles);
  all.set(shape.lines, shape.triangles.length);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, all, gl.STATIC_DRAW);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.POLYGON_OFFSET_FILL);
  gl.polygonOffset(2, 2);

  function setPalette(colors) {
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, colors.length / 3, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colors);
  }

  function draw(view) {
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    for (const [name, value] of Object.entries(view)) gl.uniform3fv(gl.getUniformLocation(program, name), value);
    const line = gl.getUniformLocation(program, "line");
    gl.uniform4f(line, 0, 0, 0, 0);
    gl.drawElements(gl.TRIANGLES, shape.triangles.length, gl.UNSIGNED_INT, 0);
    gl.uniform4f(line, 0.12, 0.14, 0.16, 1);
    gl.drawElements(gl.LINES, shape.lines.length, gl.UNSIGNED_INT, 4 * shape.triangles.length);
  }

  return { setPlaces, setShares, setPalette, draw };
}

/**
 * Shows a solid in an element, to be turned by dragging or the arrow keys and zoomed by the wheel, two fingers, + and
 * -; 0 turns it back.
 *
 * `solid` has its arrays unpacked. Gives `show(load, shares, palette)`, shares being those of the corners; nothing
 * where the browser has no WebGL 2.
 */
function solidView(host, solid, label) {
  const canvas = document.createElement("canvas");
  const shape = solidShape(solid);
  const painter = solidPainter(canvas, shape);
  if (!painter) return null;
  host.classList.add("explore-picture", "explore-turn");
  for (const [key, value] of Object.entries({ tabindex: 0, role: "application", "aria-label": label })) {
    host.setAttribute(key, value);
  }
  host.append(canvas);

  // The middle and the size of all are those before the press, so that loads compare.
  const still = solidPlaces(shape, solid.places);
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  still.forEach((value, i) => {
    low[i % 3] = Math.min(low[i % 3], value);
    high[i % 3] = Math.max(high[i % 3], value);
  });
  const middle = low.map((value, i) => 0.5 * (value + high[i]));
  const radius = 0.5 * Math.hypot(...low.map((value, i) => high[i] - value));
  let view = { ...SOLID_START };

  function draw() {
    const across = Math.max(1, Math.round(host.clientWidth * Math.min(window.devicePixelRatio, 2)));
    [canvas.width, canvas.height] = [across, Math.round(0.75 * across)];
    const [a, e] = [view.azimuth, view.elevation].map((angle) => (angle * Math.PI) / 180);
    const scale = (1.45 * view.zoom) / radius;
    painter.draw({
      right: [-Math.sin(a), Math.cos(a), 0],
      up: [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)],
      near: [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)],
      middle,
      zoom: [0.75 * scale, scale, 0.9 / radius],
    });
    host.dataset.view = [view.azimuth, view.elevation, view.zoom].map((value) => value.toFixed(2)).join(" ");
  }

  function turn(azimuth, elevation, zoom = 1) {
    view.azimuth += azimuth;
    view.elevation = Math.min(Math.max(view.elevation + elevation, -90), 90);
    view.zoom = Math.min(Math.max(view.zoom * zoom, 0.5), 12);
    draw();
  }

  const fingers = new Map();
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  };
  host.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, event);
    if (event.isTrusted) host.setPointerCapture(event.pointerId);
  });
  host.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const apart = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, event);
    if (fingers.size === 2) turn(0, 0, spread() / Math.max(apart, 1));
    else turn(-0.5 * (event.clientX - before.clientX), 0.5 * (event.clientY - before.clientY));
  });
  for (const end of ["pointerup", "pointercancel"]) {
    host.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  // A wheel over a picture that was not chosen goes on to turn the page.
  host.addEventListener("wheel", (event) => {
    if (document.activeElement !== host) return;
    event.preventDefault();
    turn(0, 0, Math.exp(-0.0015 * event.deltaY));
  }, { passive: false });
  host.addEventListener("keydown", (event) => {
    const ways = {
      ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5],
      "+": [0, 0, 1.15], "=": [0, 0, 1.15], "-": [0, 0, 1 / 1.15],
    };
    if (event.key === "0") view = { ...SOLID_START };
    else if (!ways[event.key]) return;
    turn(...(ways[event.key] ?? [0, 0]));
    event.preventDefault();
  });
  new ResizeObserver(draw).observe(host);

  function show(load, shares, palette) {
    const moved = solid.loads[load].moved;
    painter.setPlaces(solidPlaces(shape, solid.places.map((value, i) => value + moved[i])));
    painter.setShares(Float32Array.from(shape.vertices.corner, (corner) => shares[corner]));
    painter.setPalette(palette);
    draw();
  }

  return { show };
}
