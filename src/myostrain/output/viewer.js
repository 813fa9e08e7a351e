"use strict";
(() => {
  const get = (id) => document.getElementById(id);
  const data = JSON.parse(get("data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const points = new Float32Array(bytes(data.points));
  const cells = new Uint32Array(bytes(data.cells));
  const count = points.length / 3, frames = data.times.length, line = data.dim === 1;
  for (const field of data.fields) field.values = new Uint16Array(bytes(field.data));
  const moved = data.displacement && new Uint16Array(bytes(data.displacement.data));

  const canvas = get("body"), marks = get("marks");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) { get("failed").hidden = false; return; }

  const program = (vertex, fragment) => {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${text}`);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.bindAttribLocation(made, 0, "place");
    gl.bindAttribLocation(made, 1, "value");
    gl.linkProgram(made);
    return made;
  };
  const vertex = `in vec3 place; in float value; uniform mat4 view; out vec3 at; out float v;
    void main() { at = place; v = value; gl_Position = view * vec4(place, 1.0); }`;
  const solid = program(vertex, `in vec3 at; in float v; uniform sampler2D colours; uniform vec4 cut;
    uniform mat3 turn; uniform float lit; uniform vec4 flat_; out vec4 colour;
    void main() {
      if (dot(cut.xyz, at) > cut.w) discard;
      if (flat_.a > 0.0) { colour = flat_; return; }
      vec3 n = normalize(turn * cross(dFdx(at), dFdy(at)));
      float shade = mix(1.0, 0.6 + 0.4 * abs(n.z), lit);
      colour = vec4(texture(colours, vec2(clamp(v, 0.002, 0.998), 0.5)).rgb * shade, 1.0);
    }`);
  const where = (name) => gl.getUniformLocation(solid, name);
  const places = gl.createBuffer(), values = gl.createBuffer(), index = gl.createBuffer();
  const edges = gl.createBuffer(), strokes = gl.createBuffer(), resting = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, cells, gl.STATIC_DRAW);

  const size = cells.length / count && (line ? 2 : 3);
  const wire = new Uint32Array(line ? cells : cells.length * 2);
  if (!line) for (let i = 0, k = 0; i < cells.length; i += size)
    for (let j = 0; j < 3; j++) { wire[k++] = cells[i + j]; wire[k++] = cells[i + ((j + 1) % 3)]; }
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, edges);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, wire, gl.STATIC_DRAW);

  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i++) {
    low[i % 3] = Math.min(low[i % 3], points[i]); high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  const tall = line ? (high[0] - low[0]) * 0.35 : 0;
  if (line) { low[1] = 0; high[1] = tall; }
  const centre = low.map((x, i) => (x + high[i]) / 2);
  const radius = Math.hypot(...low.map((x, i) => high[i] - x)) / 2 || 1;
  let yaw, pitch, zoom, shift, frame = 0, chosen = -1, timer = null;
  const home = () => { [yaw, pitch, zoom, shift] = [data.dim > 2 ? -0.6 : 0, data.dim > 2 ? -1.1 : 0, 1, [0, 0]]; };
  home();

  const turn = () => {
    const [a, b, c, d] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return [[a, -b, 0], [c * b, c * a, -d], [d * b, d * a, c]];  // rows
  };
  const project = (p) => {
    const r = turn(), q = p.map((x, i) => x - centre[i]);
    const s = zoom / radius, ratio = canvas.width / canvas.height, wide = Math.max(1, ratio), high_ = Math.max(1, 1 / ratio);
    const t = r.map((row) => (row[0] * q[0] + row[1] * q[1] + row[2] * q[2]) * s);
    return [(t[0] + shift[0]) / wide, (t[1] + shift[1]) / high_, -t[2] / 4];
  };
  const matrix = () => {
    const o = project([0, 0, 0]), columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e) => project(e).map((x, i) => x - o[i]));
    return new Float32Array([...columns[0], 0, ...columns[1], 0, ...columns[2], 0, ...o, 1]);
  };

  const field = () => data.fields[get("field").selectedIndex];
  const place = new Float32Array(points.length), value = new Float32Array(count);
  const move = (i, j) => (moved && get("deformed").checked
    ? data.displacement.least + data.displacement.span * moved[(frame * count + i) * 3 + j] / 65535 : 0);
  const update = () => {
    const f = field(), start = frame * count;
    for (let i = 0; i < count; i++) {
      const real = f.least + f.span * f.values[start + i] / 65535;
      value[i] = (real - f.low) / (f.high - f.low);
      for (let j = 0; j < 3; j++) place[3 * i + j] = points[3 * i + j] + move(i, j);
      if (line) place[3 * i + 1] = value[i] * tall;
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, places); gl.bufferData(gl.ARRAY_BUFFER, place, gl.DYNAMIC_DRAW);
    gl.bindBuffer(gl.ARRAY_BUFFER, values); gl.bufferData(gl.ARRAY_BUFFER, value, gl.DYNAMIC_DRAW);
    get("clock").textContent = `t = ${+data.times[frame].toPrecision(4)} ${data.timeUnit}`.trim();
    get("label").textContent = f.label;
    get("low").textContent = +f.low.toPrecision(3); get("high").textContent = +f.high.toPrecision(3);
    draw();
  };
  const paint = () => {  // the colour map of the field
    const map = data.maps[field().map], row = new Uint8Array(256 * 4);
    map.forEach((rgb, i) => row.set([...rgb, 255], 4 * i));
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, row);
    for (const [key, what] of [["MIN_FILTER", gl.LINEAR], ["MAG_FILTER", gl.LINEAR], ["WRAP_S", gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${key}`], what);
    get("scale").querySelector("canvas").getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(row), 256, 1), 0, 0);
  };
  const texture = gl.createTexture();

  gl.bindBuffer(gl.ARRAY_BUFFER, resting); gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
  let stroke = 0;
  if (data.fibres) {
    const at = new Float32Array(bytes(data.fibres.points)), along = new Float32Array(bytes(data.fibres.directions));
    const half = radius * 0.8 / Math.cbrt(at.length / 3), both = new Float32Array(2 * at.length);
    for (let i = 0; i < at.length; i += 3) for (let j = 0; j < 3; j++) {
      both[2 * i + j] = at[i + j] - half * along[i + j]; both[2 * i + 3 + j] = at[i + j] + half * along[i + j];
    }
    stroke = both.length / 3;
    gl.bindBuffer(gl.ARRAY_BUFFER, strokes); gl.bufferData(gl.ARRAY_BUFFER, both, gl.STATIC_DRAW);
  } else get("fibres").disabled = true;
  if (!moved) get("deformed").disabled = true;

  const attribute = (number, buffer, width) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.enableVertexAttribArray(number);
    gl.vertexAttribPointer(number, width, gl.FLOAT, false, 0, 0);
  };
  const draw = () => {
    const wide = canvas.clientWidth * devicePixelRatio, tall_ = canvas.clientHeight * devicePixelRatio;
    for (const each of [canvas, marks]) if (each.width !== wide || each.height !== tall_) { each.width = wide; each.height = tall_; }
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT); gl.enable(gl.DEPTH_TEST);
    gl.useProgram(solid);
    gl.uniformMatrix4fv(where("view"), false, matrix());
    const r = turn();
    gl.uniformMatrix3fv(where("turn"), false, new Float32Array([0, 1, 2].flatMap((j) => r.map((row) => row[j]))));
    const axis = +get("axis").value, cut = [0, 0, 0, 1];
    if (axis >= 0) { cut[axis] = 1; cut[3] = low[axis] + (high[axis] - low[axis]) * get("cut").value; }
    gl.uniform4fv(where("cut"), cut);
    gl.uniform1f(where("lit"), data.dim > 2 ? 1 : 0);
    gl.uniform4f(where("flat_"), 0, 0, 0, 0);
    attribute(0, places, 3); attribute(1, values, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
    gl.enable(gl.POLYGON_OFFSET_FILL); gl.polygonOffset(1, 1);
    if (!line) gl.drawElements(gl.TRIANGLES, cells.length, gl.UNSIGNED_INT, 0);
    if (get("rest").checked) {
      gl.uniform4f(where("flat_"), 0.55, 0.55, 0.55, 1);
      attribute(0, resting, 3); gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, edges);
      gl.drawElements(gl.LINES, wire.length, gl.UNSIGNED_INT, 0);
    }
    if (stroke && get("fibres").checked) {
      gl.uniform4f(where("flat_"), 0.1, 0.1, 0.1, 1);
      gl.disable(gl.DEPTH_TEST);  // they lie inside
      attribute(0, strokes, 3); gl.disableVertexAttribArray(1);
      gl.drawArrays(gl.LINES, 0, stroke);
    }
    annotate();
  };

  const onScreen = (probe) => {
    const p = probe.point.map((x, j) => x + (probe.moved.length && get("deformed").checked ? probe.moved[frame][j] : 0));
    const [x, y] = project(p);
    return [(x + 1) / 2 * marks.width, (1 - y) / 2 * marks.height];
  };
  const annotate = () => {
    const pen = marks.getContext("2d"), unit = devicePixelRatio;
    pen.clearRect(0, 0, marks.width, marks.height);
    pen.font = `${13 * unit}px system-ui, sans-serif`; pen.lineWidth = 3 * unit;
    if (line) for (let i = 0; i < cells.length; i += 2) {  // lines of WebGL are a pixel wide
      const map = data.maps[field().map], ends = [cells[i], cells[i + 1]];
      const shade = (value[ends[0]] + value[ends[1]]) / 2 * 255;
      pen.strokeStyle = `rgb(${map[Math.max(0, Math.min(255, Math.round(shade)))]})`;
      pen.beginPath();
      for (const end of ends) {
        const [x, y] = project([place[3 * end], place[3 * end + 1], 0]);
        pen.lineTo((x + 1) / 2 * marks.width, (1 - y) / 2 * marks.height);
      }
      pen.stroke();
    }
    data.probes.forEach((probe, number) => {
      const [x, y] = onScreen(probe);
      pen.beginPath(); pen.arc(x, y, (number === chosen ? 7 : 5) * unit, 0, 7);
      pen.strokeStyle = "white"; pen.stroke(); pen.fillStyle = number === chosen ? "#d55e00" : "#222"; pen.fill();
      pen.strokeText(probe.name, x + 8 * unit, y - 6 * unit); pen.fillText(probe.name, x + 8 * unit, y - 6 * unit);
    });
    if (chosen >= 0) plot(data.probes[chosen]);
  };
  const plot = (probe) => {
    const pad = get("curve").querySelector("canvas"), pen = pad.getContext("2d");
    get("curve").hidden = false;
    get("probe").textContent = `potential at ${probe.name}`;
    pen.clearRect(0, 0, pad.width, pad.height);
    if (!probe.values.length) return;
    const least = Math.min(...probe.values), most = Math.max(...probe.values), end = probe.times.at(-1) || 1;
    const x = (t) => 80 + t / end * (pad.width - 100), y = (v) => pad.height - 50 - (v - least) / (most - least || 1) * (pad.height - 80);
    pen.font = "22px system-ui, sans-serif"; pen.fillStyle = pen.strokeStyle = "#222"; pen.lineWidth = 1;
    pen.strokeRect(80, 30, pad.width - 100, pad.height - 80);
    const round = (v) => (Math.abs(v) < 1e-6 * (most - least) ? "0" : `${+v.toPrecision(3)}`);
    pen.fillText(round(most), 2, 40); pen.fillText(round(least), 2, pad.height - 48);
    pen.fillText("0", 76, pad.height - 20); pen.textAlign = "right";
    pen.fillText(`t = ${+end.toPrecision(4)} ${data.timeUnit}`, pad.width - 18, pad.height - 20); pen.textAlign = "left";
    pen.strokeStyle = "#0072b2"; pen.lineWidth = 3; pen.beginPath();
    probe.times.forEach((t, i) => pen.lineTo(x(t), y(probe.values[i]))); pen.stroke();
    pen.strokeStyle = "#d55e00"; pen.beginPath(); pen.moveTo(x(data.times[frame]), 30); pen.lineTo(x(data.times[frame]), pad.height - 50); pen.stroke();
  };

  data.fields.forEach((f) => get("field").add(new Option(f.name.replaceAll("_", " "), f.name)));
  get("field").value = data.fields.some((f) => f.name === "potential") ? "potential" : data.fields[0].name;
  get("time").max = frames - 1;
  const show = (number) => { frame = number; get("time").value = number; update(); };
  get("time").addEventListener("input", () => show(+get("time").value));
  get("field").addEventListener("change", () => { paint(); update(); });
  for (const id of ["deformed", "rest", "fibres", "axis", "cut"]) get(id).addEventListener("input", update);
  get("home").addEventListener("click", () => { home(); draw(); });
  get("play").addEventListener("click", () => {
    if (timer) { clearInterval(timer); timer = null; } else timer = setInterval(() => show((frame + 1) % frames), 90);
    get("play").textContent = timer ? "Pause" : "Play";
  });
  let held = null;
  marks.addEventListener("pointerdown", (e) => { held = [e.clientX, e.clientY, e.clientX, e.clientY, e.shiftKey]; marks.setPointerCapture(e.pointerId); });
  marks.addEventListener("pointermove", (e) => {
    if (!held) return;
    const [dx, dy] = [e.clientX - held[0], e.clientY - held[1]];
    if (data.dim > 2 && !held[4]) { yaw -= dx / 150; pitch = Math.max(-Math.PI, Math.min(0, pitch - dy / 150)); } else {
      const least = Math.min(marks.clientWidth, marks.clientHeight) / 2;
      shift = [shift[0] + dx / least, shift[1] - dy / least];
    }
    held = [e.clientX, e.clientY, held[2], held[3], held[4]];
    draw();
  });
  marks.addEventListener("pointerup", (e) => {
    const still = held && Math.hypot(e.clientX - held[2], e.clientY - held[3]) < 4;
    held = null;
    if (!still) return;
    const box = marks.getBoundingClientRect(), at = [e.clientX - box.left, e.clientY - box.top].map((x) => x * devicePixelRatio);
    chosen = data.probes.findIndex((probe) => Math.hypot(...onScreen(probe).map((x, i) => x - at[i])) < 14 * devicePixelRatio);
    get("curve").hidden = chosen < 0;
    draw();
  });
  marks.addEventListener("wheel", (e) => { e.preventDefault(); zoom *= Math.exp(-e.deltaY / 700); draw(); }, { passive: false });
  addEventListener("resize", draw);
  paint();
  show(frames - 1);
  // What a test, or a bookmark such as #frame=3&field=displacement&probe=0, sets.
  const asked = new URLSearchParams(location.hash.slice(1));
  if (asked.has("field")) get("field").value = asked.get("field");
  if (asked.has("axis")) get("axis").value = asked.get("axis");
  if (asked.has("fibres")) get("fibres").checked = true;
  if (asked.has("probe")) chosen = +asked.get("probe");
  if (asked.size) { paint(); show(asked.has("frame") ? +asked.get("frame") : frame); }
  document.body.dataset.ready = `${frames} frames`;
})();
