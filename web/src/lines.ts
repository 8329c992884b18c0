// Lines with WebGL 2: one quad per segment, rounded and smoothed by its distance from the segment, dashes by the length drawn before it. Where there is
// none but an emulated one the same segments are drawn with a 2D context.

export interface Style {
  colour: string; // #rrggbb
  width: number; // CSS pixels
  dash: [number, number] | null; // on, off
}

export const STRIDE = 6; // x0 y0 x1 y1, number of the style, length before it

// A growing list of segments in CSS pixels.
export class Segments {
  data = new Float32Array(STRIDE * 4096);
  n = 0;

  clear(): void {
    this.n = 0;
  }

  add(x0: number, y0: number, x1: number, y1: number, style: number, before: number): void {
    if ((this.n + 1) * STRIDE > this.data.length) {
      const larger = new Float32Array(2 * this.data.length);
      larger.set(this.data);
      this.data = larger;
    }
    const at = this.n++ * STRIDE;
    const d = this.data;
    d[at] = x0;
    d[at + 1] = y0;
    d[at + 2] = x1;
    d[at + 3] = y1;
    d[at + 4] = style;
    d[at + 5] = before;
  }
}

const MAX_STYLES = 64;

const vertexCode = `#version 300 es
layout(location = 0) in vec4 ends;
layout(location = 1) in vec2 rest;
uniform vec2 size;
uniform float scale;
uniform vec4 styles[${2 * MAX_STYLES}];
flat out vec4 colour;
flat out vec3 look;
out vec2 place;
flat out float span;
flat out float before;
void main() {
  int number = int(rest.x) * 2;
  colour = styles[number];
  look = styles[number + 1].xyz;
  vec2 a = ends.xy, b = ends.zw, along = b - a;
  span = length(along);
  vec2 u = span > 1e-6 ? along / span : vec2(1.0, 0.0);
  vec2 v = vec2(-u.y, u.x);
  float margin = 0.5 * look.x + 1.0 / scale;
  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1));
  place = vec2(mix(-margin, span + margin, corner.x), mix(-margin, margin, corner.y));
  before = rest.y;
  vec2 at = a + u * place.x + v * place.y;
  gl_Position = vec4(at.x / size.x * 2.0 - 1.0, 1.0 - at.y / size.y * 2.0, 0.0, 1.0);
}`;

const fragmentCode = `#version 300 es
precision highp float;
flat in vec4 colour;
flat in vec3 look;
in vec2 place;
flat in float span;
flat in float before;
uniform float scale;
out vec4 result;
void main() {
  vec2 nearest = vec2(clamp(place.x, 0.0, span), 0.0);
  float cover = clamp((0.5 * look.x - distance(place, nearest)) * scale + 0.5, 0.0, 1.0);
  if (look.y > 0.0) {
    float phase = mod(before + nearest.x, look.y + look.z);
    cover *= clamp((look.y - phase) * scale + 0.5, 0.0, 1.0) * clamp(phase * scale + 0.5, 0.0, 1.0);
  }
  if (cover <= 0.0) discard;
  result = vec4(colour.rgb * cover, cover);
}`;

export interface LineRenderer {
  draw(segments: Segments, styles: Style[], width: number, height: number, scale: number): void;
}

const channels = (colour: string) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);

class Gl implements LineRenderer {
  private program: WebGLProgram;
  private buffer: WebGLBuffer;
  private capacity = 0;

  constructor(
    private canvas: HTMLCanvasElement,
    private gl: WebGL2RenderingContext,
  ) {
    this.program = gl.createProgram()!;
    for (const [kind, code] of [
      [gl.VERTEX_SHADER, vertexCode],
      [gl.FRAGMENT_SHADER, fragmentCode],
    ] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, code);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(this.program) ?? "the shader was not linked");
    this.buffer = gl.createBuffer()!;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bindVertexArray(gl.createVertexArray());
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 4, gl.FLOAT, false, 4 * STRIDE, 0);
    gl.vertexAttribDivisor(0, 1);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 2, gl.FLOAT, false, 4 * STRIDE, 16);
    gl.vertexAttribDivisor(1, 1);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  draw(segments: Segments, styles: Style[], width: number, height: number, scale: number): void {
    const gl = this.gl;
    const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    gl.viewport(0, 0, w, h);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (segments.n === 0) return;
    const table = new Float32Array(8 * MAX_STYLES);
    styles.slice(0, MAX_STYLES).forEach((s, i) => {
      table.set([...channels(s.colour), 1, s.width, s.dash ? s.dash[0] : 0, s.dash ? s.dash[1] : 0, 0], 8 * i);
    });
    gl.useProgram(this.program);
    gl.uniform2f(gl.getUniformLocation(this.program, "size"), width, height);
    gl.uniform1f(gl.getUniformLocation(this.program, "scale"), scale);
    gl.uniform4fv(gl.getUniformLocation(this.program, "styles"), table);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    const used = segments.data.subarray(0, segments.n * STRIDE);
    if (used.byteLength > this.capacity) {
      this.capacity = segments.data.byteLength;
      gl.bufferData(gl.ARRAY_BUFFER, this.capacity, gl.STREAM_DRAW);
    }
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, used);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, segments.n);
  }
}

// Segments of one style in one path each; also what a picture to save is drawn with.
export function drawOn(context: CanvasRenderingContext2D, segments: Segments, styles: Style[]): void {
  context.lineCap = "round";
  context.lineJoin = "round";
  const d = segments.data;
  for (let i = 0; i < segments.n; ) {
    const style = styles[d[i * STRIDE + 4]];
    context.beginPath();
    const first = d[i * STRIDE + 4];
    for (let [x, y] = [NaN, NaN]; i < segments.n && d[i * STRIDE + 4] === first; i++) {
      const at = i * STRIDE;
      if (d[at] !== x || d[at + 1] !== y) context.moveTo(d[at], d[at + 1]);
      context.lineTo((x = d[at + 2]), (y = d[at + 3]));
    }
    context.strokeStyle = style.colour;
    context.lineWidth = style.width;
    context.setLineDash(style.dash ?? []);
    context.stroke();
  }
  context.setLineDash([]);
}

// How drivers without graphics hardware call themselves: ANGLE's, Mesa's, Windows', Apple's.
const EMULATED = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/* None where WebGL 2 is not there or is emulated: each frame then costs several times what a 2D context takes for the same segments, and the page is put
 * together from one canvas less. Not every browser calls an emulation a caveat: the name of the driver tells. */
export function createLines(canvas: HTMLCanvasElement): LineRenderer | null {
  const gl = canvas.getContext("webgl2", { antialias: false, premultipliedAlpha: true, preserveDrawingBuffer: true, failIfMajorPerformanceCaveat: true });
  if (!gl) return null;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  if (!info || !EMULATED.test(String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)))) return new Gl(canvas, gl);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return null;
}
