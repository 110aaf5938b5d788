// `linear` (docs/algorithms/blending.md) in WebGL 2: the passes of render/gl/shaders, with depth textures for floating
// point targets, which not every telephone has. Pictures stand upright in textures: row 0 is the top one.
"use strict";

const kSlots = 6;

const kCameras = `
const int kSlots = ${kSlots};
uniform int listed;                 // cameras in use
uniform mat4 cam_from_world[kSlots];
uniform vec4 intrinsics[kSlots];    // fx fy cx cy, px of the tile
uniform vec4 tile[kSlots];          // of the sheet: x y width height; the matte stands at its right
uniform vec2 planes[kSlots];        // near and far of the depth map
uniform vec3 center[kSlots];
`;

const kView = `
uniform vec4 view_k;                // f f cx cy
uniform vec2 view_planes;
uniform mat4 world_from_view;
uniform vec3 eye;
float depth_of(float d, vec2 nf) { return nf.y * nf.x / (nf.y - d * (nf.y - nf.x)); }
vec3 world_at(vec2 pixel, float z) {
  return (world_from_view * vec4(vec2((pixel - view_k.zw) / view_k.xy) * z, z, 1.0)).xyz;
}
`;

const kPhoto = `
uniform highp sampler2D sheet;
// Where camera i's tile shows a point of its coordinates; false outside.
bool tile_pixel(int i, vec3 p, out vec2 pixel) {
  pixel = vec2(-1.0);
  if (p.z <= 0.0) return false;
  pixel = intrinsics[i].xy * p.xy / p.z + intrinsics[i].zw;
  return all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, tile[i].zw));
}
vec3 read(int i, vec2 pixel, float right) {
  vec2 at = clamp(pixel, vec2(0.5), tile[i].zw - 0.5) + tile[i].xy + vec2(right * tile[i].z, 0.0);
  return textureLod(sheet, at / vec2(textureSize(sheet, 0)), 0.0).rgb;
}
float matte(int i, vec2 pixel) { return read(i, pixel, 1.0).g; }
// A Catmull-Rom spline in nine bilinear reads.
vec3 color(int i, vec2 pixel) {
  pixel = clamp(pixel, vec2(0.5), tile[i].zw - 0.5);
  vec2 low = floor(pixel - 0.5) + 0.5, f = pixel - low;
  vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f)), w1 = 1.0 + f * f * (1.5 * f - 2.5);
  vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f)), w3 = f * f * (0.5 * f - 0.5), w12 = w1 + w2;
  vec2 a = low - 1.0, b = low + w2 / w12, c = low + 2.0;
  vec3 sum = (read(i, vec2(a.x, a.y), 0.0) * w0.x + read(i, vec2(b.x, a.y), 0.0) * w12.x + read(i, vec2(c.x, a.y), 0.0) * w3.x) * w0.y
           + (read(i, vec2(a.x, b.y), 0.0) * w0.x + read(i, vec2(b.x, b.y), 0.0) * w12.x + read(i, vec2(c.x, b.y), 0.0) * w3.x) * w12.y
           + (read(i, vec2(a.x, c.y), 0.0) * w0.x + read(i, vec2(b.x, c.y), 0.0) * w12.x + read(i, vec2(c.x, c.y), 0.0) * w3.x) * w3.y;
  return clamp(sum, 0.0, 1.0);
}
`;

const kHead = "#version 300 es\nprecision highp float;\nprecision highp int;\n";

const shaders = {
  // The proxy as a camera sees it, in the pixels of its tile.
  depthVertex: `${kHead}
in vec3 position;
uniform mat4 to_camera;
uniform vec4 k;
uniform vec4 size_planes;           // width, height, near, far
void main() {
  vec3 p = (to_camera * vec4(position, 1.0)).xyz;
  vec2 pixel = k.xy * p.xy + k.zw * p.z;
  float n = size_planes.z, f = size_planes.w, z = f * (p.z - n) / (f - n);
  gl_Position = vec4(2.0 * pixel / size_planes.xy - p.z, 2.0 * z - p.z, p.z);
}`,
  depthFragment: `${kHead}void main() {}`,

  surfaceVertex: `${kHead}
in vec3 position;
uniform mat4 to_camera;
uniform vec4 k;
uniform vec4 size_planes;
out vec3 world;
void main() {
  world = position;
  vec3 p = (to_camera * vec4(position, 1.0)).xyz;
  vec2 pixel = k.xy * p.xy + k.zw * p.z;
  float n = size_planes.z, f = size_planes.w, z = f * (p.z - n) / (f - n);
  gl_Position = vec4(2.0 * pixel / size_planes.xy - p.z, 2.0 * z - p.z, p.z);
}`,
  surfaceFragment: `${kHead}
in vec3 world;
uniform vec3 eye;
out vec4 normal;
void main() {
  vec3 n = cross(dFdx(world), dFdy(world));
  float l = dot(n, n);
  n = l > 0.0 ? n * inversesqrt(l) : normalize(eye - world);
  if (dot(n, eye - world) < 0.0) n = -n;
  normal = vec4(0.5 * n + 0.5, 1.0);
}`,

  screenVertex: `${kHead}
void main() {
  vec2 at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(at, 0.0, 1.0);
}`,

  // A bit for each camera that may be used here; the highest bit: the proxy is here.
  visibilityFragment: `${kHead}${kCameras}${kView}${kPhoto}
uniform highp sampler2D surface_depth;
uniform highp sampler2D surface_normal;
uniform highp sampler2DArray depth_maps;
uniform float tolerance;
out uvec4 result;
float seen(int i, vec3 p, vec3 n) {
  if (-dot(n, p) * inversesqrt(dot(p, p)) < 0.02) return 0.0;
  vec2 at = intrinsics[i].xy * p.xy / p.z + intrinsics[i].zw - 0.5;
  ivec2 size = ivec2(tile[i].zw), low = ivec2(floor(at));
  if (any(lessThan(low, ivec2(0))) || any(greaterThan(low, size - 2))) return 1.0;
  vec2 f = at - vec2(low);
  float plane = dot(n, p), sum = 0.0;
  for (int c = 0; c < 4; ++c) {
    ivec2 offset = ivec2(c & 1, c >> 1);
    vec2 ray = (vec2(low + offset) + 0.5 - intrinsics[i].zw) / intrinsics[i].xy;
    float expected = clamp(plane / min(dot(n, vec3(ray, 1.0)), -1e-6), p.z - 2.0 * tolerance, p.z + 2.0 * tolerance);
    float weight = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
    float d = texelFetch(depth_maps, ivec3(low + offset, i), 0).r;
    if (d >= 1.0 || depth_of(d, planes[i]) >= expected - tolerance) sum += weight;
  }
  return sum;
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float d = texelFetch(surface_depth, at, 0).r;
  result = uvec4(0u);
  if (d >= 1.0) return;
  vec3 world = world_at(gl_FragCoord.xy, depth_of(d, view_planes));
  vec3 normal = normalize(2.0 * texelFetch(surface_normal, at, 0).xyz - 1.0);
  uint bits = 128u;
  for (int i = 0; i < kSlots; ++i) {
    if (i >= listed) break;
    vec3 p = (cam_from_world[i] * vec4(world, 1.0)).xyz;
    vec2 pixel;
    if (tile_pixel(i, p, pixel) && matte(i, pixel) >= 0.5 && seen(i, p, mat3(cam_from_world[i]) * normal) >= 0.5)
      bits |= 1u << i;
  }
  result.x = bits;
}`,

  // Distance along the row to the next pixel that a camera does not see, a byte each (Eq. 11.5, first pass).
  rowsFragment: `${kHead}
uniform highp usampler2D visibility;
uniform int listed;
uniform int radius;
uniform int width;
out uvec4 distances;
uint hidden(int x, int y) {
  if (x < 0 || x >= width) return 0u;
  uint v = texelFetch(visibility, ivec2(x, y), 0).x;
  return (v & 128u) == 0u ? 0u : ~v;
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  uint todo = (1u << listed) - 1u;
  distances = uvec4(0xffffffffu);
  for (int d = 0; d <= radius; ++d) {
    uint found = (hidden(at.x - d, at.y) | hidden(at.x + d, at.y)) & todo;
    if (found == 0u) continue;
    todo &= ~found;
    for (int i = 0; i < ${kSlots}; ++i) {
      if ((found >> i & 1u) == 0u) continue;
      uint shift = uint(i & 3) * 8u;
      if (i < 4) distances.x = (distances.x & ~(255u << shift)) | uint(d) << shift;
      else distances.y = (distances.y & ~(255u << shift)) | uint(d) << shift;
    }
    if (todo == 0u) break;
  }
}`,

  // Angular weight times soft visibility, normalised, and the photographs' weighted mean.
  blendFragment: `${kHead}${kCameras}${kView}${kPhoto}
uniform highp sampler2D surface_depth;
uniform highp usampler2D visibility;
uniform highp usampler2D rows;
uniform vec2 fades[kSlots];
uniform int radius;
uniform ivec2 size;
uniform vec3 background;
out vec4 result;
void main() {
  ivec2 at = ivec2(int(gl_FragCoord.x), size.y - 1 - int(gl_FragCoord.y));
  result = vec4(background, 1.0);
  uint here = texelFetch(visibility, at, 0).x;
  if ((here & 128u) == 0u) return;
  float nearest2[kSlots];
  for (int i = 0; i < kSlots; ++i) nearest2[i] = 1e9;
  for (int dy = -radius; dy <= radius; ++dy) {
    int y = at.y + dy;
    if (y < 0 || y >= size.y) continue;
    uvec2 row = texelFetch(rows, ivec2(at.x, y), 0).xy;
    if (row == uvec2(0xffffffffu)) continue;
    for (int i = 0; i < kSlots; ++i) {
      uint dx = ((i < 4 ? row.x : row.y) >> (uint(i & 3) * 8u)) & 255u;
      if (dx != 255u) nearest2[i] = min(nearest2[i], float(dx * dx) + float(dy * dy));
    }
  }
  vec3 world = world_at(vec2(at) + 0.5, depth_of(texelFetch(surface_depth, at, 0).r, view_planes));
  vec3 to_view = normalize(eye - world), sum = vec3(0.0);
  // Who counts: see render/gl/shaders/weights.comp, which says the same.
  float angular[kSlots], soft[kSlots], all_chosen = 1e-30, chosen = 0.0, all_listed = 1e-30, in_list = 0.0, in_picture = 0.0;
  float strongest = 0.0, second = 0.0, beside = 0.0;
  vec2 pixel[kSlots];
  bool reached[kSlots];
  for (int i = 0; i < kSlots; ++i) {
    if (i >= listed) break;
    float chord = distance(to_view, normalize(center[i] - world));
    angular[i] = 1.0 / max(2.0 * asin(min(0.5 * chord, 1.0)), 2e-5);
    reached[i] = tile_pixel(i, (cam_from_world[i] * vec4(world, 1.0)).xyz, pixel[i]);
    bool visible = (here >> i & 1u) != 0u;
    soft[i] = !visible ? 0.0 : radius < 1 ? 1.0 : min(sqrt(nearest2[i]) / float(radius), 1.0);
    vec2 as = angular[i] * fades[i];
    all_chosen += as.x;
    chosen += as.x * soft[i];
    all_listed += as.y;
    in_list += as.y * soft[i];
    second = max(second, min(strongest, as.y));
    strongest = max(strongest, as.y);
    if (reached[i]) in_picture += as.y;
    else beside = max(beside, as.y);
  }
  float of_chosen = 1.0 / max(chosen, 0.3 * all_chosen), rest = 1.0 - chosen * of_chosen;
  float enough_listed = 0.01 * (all_listed - max(0.0, beside - second));
  float of_list = rest / max(in_list, enough_listed);
  rest -= in_list * of_list;
  float of_picture = rest / max(in_picture, enough_listed), of_any = (rest - in_picture * of_picture) / all_listed;
  float total = 0.0;
  for (int i = 0; i < kSlots; ++i) {
    if (i >= listed) break;
    float seen = soft[i] * (fades[i].x * of_chosen + fades[i].y * of_list);
    float w = angular[i] * (seen + fades[i].y * (of_any + (reached[i] ? of_picture : 0.0)));
    if (w < 1e-6) continue;
    sum += w * color(i, pixel[i]);
    total += w;
  }
  result = vec4(sum / total, 1.0);
}`,
};
