// The take's instants: scripts of base64, because a page from a file may load scripts and nothing else.
"use strict";

const kDecoded = 8;                 // instants kept ready

const frameFiles = new Map();       // by number: what its script said
function frameLoaded(number, data) { frameFiles.set(number, data); }

function bytesOf(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

function loadScript(source) {
  return new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = source;
    script.onload = () => { script.remove(); done(); };
    script.onerror = () => failed(new Error(`${source} is missing; copy the whole folder`));
    document.head.append(script);
  });
}

class Frames {
  constructor(take) {
    this.take = take;
    this.files = new Map();
    this.decoded = new Map();
  }

  // A promise of an instant as Renderer.show() wants it; kept while it is among the last ones asked for.
  get(number) {
    const known = this.decoded.get(number);
    this.decoded.delete(number);
    const instant = known ?? this.decode(number);
    this.decoded.set(number, instant);
    if (!known) instant.catch(() => this.decoded.delete(number));
    for (const old of this.decoded.keys()) {
      if (this.decoded.size <= kDecoded) break;
      this.decoded.get(old).then((i) => i.picture.close(), () => {});
      this.decoded.delete(old);
    }
    return instant;
  }

  file(number) {
    if (!this.files.has(number)) {
      const name = `frames/${String(this.take.frames[number]).padStart(6, "0")}.js`;
      this.files.set(number, loadScript(name).then(() => frameFiles.get(this.take.frames[number])));
      this.files.get(number).catch(() => this.files.delete(number));
    }
    return this.files.get(number);
  }

  async decode(number) {
    const file = await this.file(number), { low, high, vertices, tiles } = file;
    const bytes = bytesOf(file.mesh).buffer, steps = new Uint16Array(bytes, 0, 3 * vertices);
    const positions = new Float32Array(3 * vertices);
    for (let i = 0; i < positions.length; ++i) positions[i] = low[i % 3] + (high[i % 3] - low[i % 3]) * (steps[i] / 65535);
    const begin = (6 * vertices + 3) & ~3;
    const indices = vertices <= 65536 ? new Uint16Array(bytes, begin) : new Uint32Array(bytes, begin);
    const blob = new Blob([bytesOf(file.sheet)], { type: "image/jpeg" });
    const picture = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    const triangles = indices.length / 3, stride = Math.max(1, Math.floor(triangles / 96)), samples = [];
    const corner = (i) => [...positions.subarray(3 * indices[i], 3 * indices[i] + 3)];
    for (let t = 0; t < triangles; t += stride) {
      const point = corner(3 * t), across = vec.cross(vec.sub(corner(3 * t + 1), point), vec.sub(corner(3 * t + 2), point));
      samples.push({ point, normal: vec.mul(across, 1 / Math.max(vec.length(across), 1e-30)) });
    }
    const middle = vec.mul(vec.add(low, high), 0.5), radius = 0.5 * vec.length(vec.sub(high, low)) + 1e-6;
    return { positions, indices, picture, tiles, samples, middle, radius };
  }
}
