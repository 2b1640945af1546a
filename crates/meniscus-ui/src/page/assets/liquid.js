// The liquid in its glass, in 3D: every tracer a shaded ball, the glass a transparent wall.

import * as twgl from './twgl.js';
import { colours } from './colours.js';

const BALLS = [`#version 300 es
uniform mat4 view, projection;
uniform float radius, pixels, low, high;
in vec3 place;
in float value;
out float at;
out vec4 middle;
void main() {
  middle = view * vec4(place, 1.0);
  gl_Position = projection * middle;
  gl_PointSize = pixels * projection[1][1] * radius / gl_Position.w;
  at = clamp((value - low) / (high - low), 0.0, 1.0);
}`, `#version 300 es
precision highp float;
uniform sampler2D map;
uniform mat4 projection;
uniform float radius;
in float at;
in vec4 middle;
out vec4 colour;
void main() {
  vec2 on = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float inside = 1.0 - dot(on, on);
  if (inside < 0.0) discard;
  vec3 normal = vec3(on, sqrt(inside));
  vec4 clip = projection * (middle + vec4(radius * normal, 0.0));
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
  vec3 light = normalize(vec3(-0.35, 0.6, 0.75));
  float shade = 0.55 + 0.45 * max(dot(normal, light), 0.0);
  float glint = 0.25 * pow(max(dot(reflect(-light, normal), vec3(0.0, 0.0, 1.0)), 0.0), 24.0);
  colour = vec4(texture(map, vec2(at, 0.5)).rgb * shade + glint, 1.0);
}`];

const GLASS = [`#version 300 es
uniform mat4 view, projection;
in vec3 position, normal;
out vec3 facing, from;
void main() {
  vec4 seen = view * vec4(position, 1.0);
  facing = mat3(view) * normal;
  from = seen.xyz;
  gl_Position = projection * seen;
}`, `#version 300 es
precision highp float;
uniform vec3 tint;
uniform float least;
in vec3 facing, from;
out vec4 colour;
void main() {
  float grazing = 1.0 - abs(dot(normalize(facing), normalize(from)));
  colour = vec4(tint, least + 0.45 * pow(grazing, 3.0));
}`];

/** Wall, rim and foot of a glass, as triangles with normals: [from z, to z, inner radius, outer radius]. */
function glassParts({ radius_m, rim_m }) {
  const [outer, foot, steps] = [radius_m + 0.0018, -0.004, 96];
  const position = [], normal = [], indices = [];
  const ring = (r0, z0, r1, z1, n0, nz) => {
    const first = position.length / 3;
    for (let k = 0; k <= steps; k++) {
      const [x, y] = [Math.cos(2 * Math.PI * k / steps), Math.sin(2 * Math.PI * k / steps)];
      position.push(r0 * x, r0 * y, z0, r1 * x, r1 * y, z1);
      normal.push(n0 * x, n0 * y, nz, n0 * x, n0 * y, nz);
      if (k < steps) indices.push(...[0, 1, 2, 2, 1, 3].map((corner) => first + 2 * k + corner));
    }
  };
  ring(outer, foot, outer, rim_m, 1, 0);
  ring(radius_m, rim_m, outer, rim_m, 0.9, 0.45);
  ring(0, foot, outer, foot, 0, 1);
  return { position, normal, indices };
}

/** A grid on the table, two centimetres wide: what the glass moves over. */
function table() {
  const lines = [];
  for (let k = -7; k <= 7; k++) lines.push(k / 50, -0.14, -0.0045, k / 50, 0.14, -0.0045, -0.14, k / 50, -0.0045, 0.14, k / 50, -0.0045);
  return lines;
}

const LINES = [`#version 300 es
uniform mat4 view, projection;
in vec3 position;
out vec2 on;
void main() { on = position.xy; gl_Position = projection * view * vec4(position, 1.0); }`, `#version 300 es
precision highp float;
uniform vec3 tint;
in vec2 on;
out vec4 colour;
void main() { colour = vec4(tint, 0.45 * (1.0 - smoothstep(0.05, 0.13, length(on)))); }`];

export class Liquid {
  /** Gives `null` in `gl` where the browser has no WebGL 2. */
  constructor(canvas) {
    this.canvas = canvas;
    this.reset();
    this.glassX = 0;
    this.stale = true;
    this.orbit();
    this.start();
    // A graphics driver may take its context back, and give another.
    canvas.addEventListener('webglcontextlost', (event) => { event.preventDefault(); this.gl = null; });
    canvas.addEventListener('webglcontextrestored', () => { this.start(); if (this.model) this.take(this.model); });
  }

  /** The view as it began. */
  reset() {
    Object.assign(this, { turn: -0.55, lift: 0.28, far: 0.3, stale: true });
  }

  start() {
    const gl = this.canvas.getContext('webgl2', { antialias: true, alpha: true });
    this.gl = gl;
    if (!gl) return;
    [this.balls, this.wall, this.lines] = [BALLS, GLASS, LINES].map((shaders) => twgl.createProgramInfo(gl, shaders));
    this.map = twgl.createTexture(gl, { width: 256, height: 1, src: colours(), min: gl.LINEAR, mag: gl.LINEAR, wrap: gl.CLAMP_TO_EDGE });
    this.table = twgl.createBufferInfoFromArrays(gl, { position: { numComponents: 3, data: table() } });
  }

  /** Another model: another glass, other tracers. */
  take(model) {
    this.model = model;
    const { gl } = this;
    if (!gl) return;
    this.glass = twgl.createBufferInfoFromArrays(gl, glassParts(model.facts));
    this.cloud = twgl.createBufferInfoFromArrays(gl, {
      place: { numComponents: 3, data: model.now.q, drawType: gl.DYNAMIC_DRAW },
      value: { numComponents: 1, data: model.values, drawType: gl.DYNAMIC_DRAW },
    });
    this.stale = true;
  }

  /** The model's present field, coloured from `low` to `high`, in a glass at `x`. */
  show(low, high, x) {
    Object.assign(this, { low, high });
    if (Number.isFinite(x)) this.glassX = x;
    if (this.gl && this.cloud) {
      twgl.setAttribInfoBufferFromArray(this.gl, this.cloud.attribs.place, this.model.now.q);
      twgl.setAttribInfoBufferFromArray(this.gl, this.cloud.attribs.value, this.model.values);
    }
    this.stale = true;
  }

  draw() {
    const { gl, canvas } = this;
    const resized = gl && twgl.resizeCanvasToDisplaySize(canvas, Math.min(devicePixelRatio, 2));
    if (!gl || !this.cloud || !(this.stale || resized)) return;
    this.stale = false;
    const ink = getComputedStyle(canvas);
    const tint = (name) => ink.getPropertyValue(`--${name}`).match(/[0-9a-f]{2}/gi).map((pair) => parseInt(pair, 16) / 255);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { fill_m, rim_m } = this.model.facts;
    const aspect = canvas.width / canvas.height;
    // The eye goes half the way with the glass, so that it is seen to move and stays in sight.
    this.followed = (this.followed ?? this.glassX) + 0.12 * (this.glassX - (this.followed ?? this.glassX));
    const target = [0.6 * this.followed, 0, 0.47 * rim_m];
    const far = this.far * Math.max(1, 0.95 / aspect);
    const [c, s] = [Math.cos(this.lift), Math.sin(this.lift)];
    const eye = [target[0] + far * c * Math.sin(this.turn), -far * c * Math.cos(this.turn), target[2] + far * s];
    const room = twgl.m4.inverse(twgl.m4.lookAt(eye, target, [0, 0, 1]));
    const projection = twgl.m4.perspective(0.6, aspect, 0.02, 2);
    const view = twgl.m4.translate(room, [this.glassX, 0, 0]);
    const draw = (program, buffers, uniforms, kind) => {
      gl.useProgram(program.program);
      twgl.setBuffersAndAttributes(gl, program, buffers);
      twgl.setUniforms(program, uniforms);
      twgl.drawBufferInfo(gl, buffers, kind);
    };
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    // A ball fills the place that its tracer stands for.
    const radius = 0.58 * Math.cbrt(Math.PI * this.model.facts.radius_m ** 2 * fill_m / this.model.tracers);
    draw(this.balls, this.cloud, { view, projection, radius, pixels: canvas.height, low: this.low ?? 0, high: this.high ?? 1, map: this.map }, gl.POINTS);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    draw(this.lines, this.table, { view: room, projection, tint: tint('dim') }, gl.LINES);
    draw(this.wall, this.glass, { view, projection, tint: tint('glass'), least: 0.04 });
  }

  /** Drag to turn, wheel or two fingers to come nearer. */
  orbit() {
    const { canvas } = this;
    const down = new Map();
    const nearer = (factor) => { this.far = Math.min(0.8, Math.max(0.15, this.far * factor)); this.stale = true; };
    const apart = () => { const [a, b] = [...down.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    canvas.addEventListener('pointerdown', (event) => { down.set(event.pointerId, { x: event.x, y: event.y }); canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener('pointermove', (event) => {
      const last = down.get(event.pointerId);
      if (!last) return;
      const before = down.size === 2 ? apart() : 0;
      const [dx, dy] = [event.x - last.x, event.y - last.y];
      down.set(event.pointerId, { x: event.x, y: event.y });
      if (down.size === 2) return nearer(before / Math.max(apart(), 1));
      this.turn -= 0.008 * dx;
      this.lift = Math.min(1.5, Math.max(-0.2, this.lift + 0.008 * dy));
      this.stale = true;
    });
    for (const kind of ['pointerup', 'pointercancel']) canvas.addEventListener(kind, (event) => down.delete(event.pointerId));
    canvas.addEventListener('wheel', (event) => { event.preventDefault(); nearer(Math.exp(0.001 * event.deltaY)); }, { passive: false });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this.stale = true; });
  }
}
