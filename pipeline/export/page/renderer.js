// Draws an instant (its mesh and its sheet of photographs) from a view: four passes, see shaders.js.
"use strict";

const kSoftRadius = 8;              // px of the view: r of Eq. 11.5
const kToleranceShare = 0.0125;     // of the mesh's diagonal (docs/adr/0063)

class Renderer {
  constructor(canvas, cameras) {
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
    if (!gl) throw new Error("This browser has no WebGL 2, which the page draws with.");
    this.gl = gl;
    this.canvas = canvas;
    this.cameras = cameras;
    this.depthProgram = this.program(shaders.depthVertex, shaders.depthFragment);
    this.surfaceProgram = this.program(shaders.surfaceVertex, shaders.surfaceFragment);
    this.visibilityProgram = this.program(shaders.screenVertex, shaders.visibilityFragment);
    this.rowsProgram = this.program(shaders.screenVertex, shaders.rowsFragment);
    this.blendProgram = this.program(shaders.screenVertex, shaders.blendFragment);
    this.mesh = gl.createVertexArray();
    this.positions = gl.createBuffer();
    this.indices = gl.createBuffer();
    this.nothing = gl.createVertexArray();
    this.sheet = gl.createTexture();
    this.targets = null;
    this.depthMaps = null;
    this.fence = null;
  }

  program(vertex, fragment) {
    const gl = this.gl, p = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const s = gl.createShader(type);
      gl.shaderSource(s, text);
      gl.compileShader(s);
      gl.attachShader(p, s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s) || "the graphics context is gone");
    }
    gl.bindAttribLocation(p, 0, "position");
    gl.linkProgram(p);
    if (!gl.getProgramParameter(p, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(p));
    const places = new Map();
    return { p, at: (name) => { if (!places.has(name)) places.set(name, gl.getUniformLocation(p, name)); return places.get(name); } };
  }

  texture(format, width, height, layers) {
    const gl = this.gl, target = layers ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D, t = gl.createTexture();
    gl.bindTexture(target, t);
    if (layers) gl.texStorage3D(target, 1, format, width, height, layers);
    else gl.texStorage2D(target, 1, format, width, height);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(target, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(target, name, gl.CLAMP_TO_EDGE);
    return t;
  }

  framebuffer(color, depth) {
    const gl = this.gl, f = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, f);
    if (color) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, color, 0);
    if (depth) gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depth, 0);
    return f;
  }

  // Targets of the canvas's size.
  resize(width, height) {
    const gl = this.gl, old = this.targets;
    if (old && old.width === width && old.height === height) return;
    if (old) {
      for (const t of [old.normal, old.depth, old.visibility, old.rows]) gl.deleteTexture(t);
      for (const f of [old.surface, old.seen, old.distances]) gl.deleteFramebuffer(f);
    }
    const t = { width, height };
    t.normal = this.texture(gl.RGBA8, width, height);
    t.depth = this.texture(gl.DEPTH_COMPONENT32F, width, height);
    t.visibility = this.texture(gl.R8UI, width, height);
    t.rows = this.texture(gl.RG32UI, width, height);
    t.surface = this.framebuffer(t.normal, t.depth);
    t.seen = this.framebuffer(t.visibility, null);
    t.distances = this.framebuffer(t.rows, null);
    this.targets = t;
  }

  // An instant: {positions: Float32Array, indices: Uint16Array or Uint32Array, picture: ImageBitmap,
  // tiles: by camera [x, y, width, height, left, top, scale] or null}.
  show(instant) {
    const gl = this.gl;
    this.instant = instant;
    gl.bindVertexArray(this.mesh);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.positions);
    gl.bufferData(gl.ARRAY_BUFFER, instant.positions, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, instant.indices, gl.DYNAMIC_DRAW);
    this.indexType = instant.indices instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
    gl.bindTexture(gl.TEXTURE_2D, this.sheet);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, gl.RGB, gl.UNSIGNED_BYTE, instant.picture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    const width = Math.max(...instant.tiles.map((t) => t ? t[2] : 1)), height = Math.max(...instant.tiles.map((t) => t ? t[3] : 1));
    if (!this.depthMaps || this.depthMaps.width < width || this.depthMaps.height < height) {
      if (this.depthMaps) gl.deleteTexture(this.depthMaps.texture);
      this.depthMaps = { width, height, texture: this.texture(gl.DEPTH_COMPONENT32F, width, height, kSlots) };
      this.depthTarget ??= gl.createFramebuffer();
    }
    this.drawnDepths = [];
  }

  // Near and far of a camera or view, around the mesh.
  planesFrom(matrix) {
    const { middle, radius } = this.instant, z = matrix[2] * middle[0] + matrix[6] * middle[1] + matrix[10] * middle[2] + matrix[14];
    return [Math.max(z - radius, 1e-3 * radius), Math.max(z + radius, radius)];
  }

  intrinsicsOf(camera, tile) {
    const s = tile[6];
    return [camera.fx * s, camera.fy * s, camera.cx * s - tile[4], camera.cy * s - tile[5]];
  }

  drawMesh(program, matrix, k, width, height, planes) {
    const gl = this.gl;
    gl.useProgram(program.p);
    gl.uniformMatrix4fv(program.at("to_camera"), false, matrix);
    gl.uniform4fv(program.at("k"), k);
    gl.uniform4f(program.at("size_planes"), width, height, planes[0], planes[1]);
    gl.bindVertexArray(this.mesh);
    gl.enable(gl.DEPTH_TEST);
    gl.drawElements(gl.TRIANGLES, this.instant.indices.length, this.indexType, 0);
    gl.disable(gl.DEPTH_TEST);
  }

  // Depth maps of the listed cameras, drawn once an instant and slot.
  drawDepths(choice) {
    const gl = this.gl, maps = this.depthMaps;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.depthTarget);
    gl.drawBuffers([gl.NONE]);
    gl.viewport(0, 0, maps.width, maps.height);
    choice.forEach(({ index }, slot) => {
      if (this.drawnDepths[slot] === index) return;
      this.drawnDepths[slot] = index;
      const camera = this.cameras[index], tile = this.instant.tiles[index];
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, maps.texture, 0, slot);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      this.drawMesh(this.depthProgram, camera.matrix, this.intrinsicsOf(camera, tile), maps.width, maps.height, this.planesFrom(camera.matrix));
    });
  }

  bind(program, textures) {
    const gl = this.gl;
    gl.useProgram(program.p);
    Object.entries(textures).forEach(([name, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(name === "depth_maps" ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D, texture);
      gl.uniform1i(program.at(name), unit);
    });
    gl.activeTexture(gl.TEXTURE0);
    gl.bindVertexArray(this.nothing);
  }

  setCameras(program, choice) {
    const gl = this.gl, all = (pick, width) => {
      const values = new Float32Array(kSlots * width);
      choice.forEach(({ index }, slot) => values.set(pick(this.cameras[index], this.instant.tiles[index]), slot * width));
      return values;
    };
    gl.uniform1i(program.at("listed"), choice.length);
    gl.uniformMatrix4fv(program.at("cam_from_world[0]"), false, all((c) => c.matrix, 16));
    gl.uniform4fv(program.at("intrinsics[0]"), all((c, t) => this.intrinsicsOf(c, t), 4));
    gl.uniform4fv(program.at("tile[0]"), all((c, t) => t.slice(0, 4), 4));
    gl.uniform2fv(program.at("planes[0]"), all((c) => this.planesFrom(c.matrix), 2));
    gl.uniform3fv(program.at("center[0]"), all((c) => c.center, 3));
  }

  setView(program, view, planes) {
    const gl = this.gl, [r, d, f] = view.rows;
    gl.uniform4f(program.at("view_k"), view.f, view.f, view.cx, view.cy);
    gl.uniform2fv(program.at("view_planes"), planes);
    gl.uniform3fv(program.at("eye"), view.eye);
    gl.uniformMatrix4fv(program.at("world_from_view"), false, [...r, 0, ...d, 0, ...f, 0, ...view.eye, 1]);
  }

  // Whether the graphics processor is done with the last picture: software, and small ones, work long after draw().
  get isDone() {
    if (!this.fence) return true;
    if (this.gl.getSyncParameter(this.fence, this.gl.SYNC_STATUS) !== this.gl.SIGNALED) return false;
    this.gl.deleteSync(this.fence);
    this.fence = null;
    return true;
  }

  // The picture on the canvas. `key` is a camera path's: eye, target, up, fov_y.
  draw(key, blend, background) {
    const gl = this.gl, width = this.canvas.width, height = this.canvas.height;
    if (!this.instant || this.instant.indices.length === 0) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.clearColor(...background, 1);
      gl.clear(gl.COLOR_BUFFER_BIT);
      return;
    }
    this.resize(width, height);
    const view = viewOf(key, width, height), t = this.targets;
    const pictured = this.instant.tiles.map((tile) => tile !== null);
    const choice = chooseCameras(this.cameras, this.instant.samples, view, blend, pictured);
    const [r, d, f] = view.rows;
    const matrix = [r[0], d[0], f[0], 0, r[1], d[1], f[1], 0, r[2], d[2], f[2], 0,
      -vec.dot(r, view.eye), -vec.dot(d, view.eye), -vec.dot(f, view.eye), 1];
    const planes = this.planesFrom(matrix);
    gl.depthFunc(gl.LESS);
    this.drawDepths(choice);

    gl.bindFramebuffer(gl.FRAMEBUFFER, t.surface);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.surfaceProgram.p);
    gl.uniform3fv(this.surfaceProgram.at("eye"), view.eye);
    this.drawMesh(this.surfaceProgram, matrix, [view.f, view.f, view.cx, view.cy], width, height, planes);

    gl.bindFramebuffer(gl.FRAMEBUFFER, t.seen);
    const look = this.visibilityProgram;
    this.bind(look, { sheet: this.sheet, surface_depth: t.depth, surface_normal: t.normal, depth_maps: this.depthMaps.texture });
    this.setCameras(look, choice);
    this.setView(look, view, planes);
    gl.uniform1f(look.at("tolerance"), kToleranceShare * 2 * this.instant.radius);
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    gl.bindFramebuffer(gl.FRAMEBUFFER, t.distances);
    this.bind(this.rowsProgram, { visibility: t.visibility });
    gl.uniform1i(this.rowsProgram.at("listed"), choice.length);
    gl.uniform1i(this.rowsProgram.at("radius"), kSoftRadius);
    gl.uniform1i(this.rowsProgram.at("width"), width);
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const mix = this.blendProgram;
    this.bind(mix, { sheet: this.sheet, surface_depth: t.depth, visibility: t.visibility, rows: t.rows });
    this.setCameras(mix, choice);
    this.setView(mix, view, planes);
    gl.uniform2fv(mix.at("fades[0]"), choice.flatMap((c) => [c.fade, c.standIn]).concat(Array(2 * (kSlots - choice.length)).fill(0)));
    gl.uniform1i(mix.at("radius"), kSoftRadius);
    gl.uniform2i(mix.at("size"), width, height);
    gl.uniform3fv(mix.at("background"), background);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    if (this.fence) gl.deleteSync(this.fence);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
  }
}
