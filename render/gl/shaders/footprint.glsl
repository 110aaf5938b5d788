// Photographs as large as the view's pixels see them. The twin of render/footprint.h and
// render/cpu/footprint_kernels.cpp.
const float kSharpArea = 1.5, kLeastFacing = 1e-3;

// The square of the shorter axis of a pixel's footprint in a photograph, in pixels of it; `normal` and z are the
// surface's there.
float footprint(int index, vec2 window_pixel, vec3 normal, float z) {
  mat3 to_world = mat3(view.world_from_view), to_camera = mat3(cameras[index].cam_from_world);
  vec3 ray = to_world * view_ray(window_pixel);
  float facing = 1.0 / min(dot(normal, ray), -kLeastFacing);
  vec3 p = (cameras[index].cam_from_world * vec4(world_at(window_pixel, z), 1.0)).xyz;
  vec2 at = p.xy / max(p.z, 1e-6), k = cameras[index].intrinsics.xy * (z / max(p.z, 1e-6));
  vec3 x = to_world * vec3(1.0 / view.view_k.x, 0.0, 0.0);
  vec3 y = to_world * vec3(-view.settings.x / (view.view_k.x * view.view_k.y), 1.0 / view.view_k.y, 0.0);
  x = to_camera * (x - dot(normal, x) * facing * ray);
  y = to_camera * (y - dot(normal, y) * facing * ray);
  vec2 dx = k * (x.xy - at * x.z), dy = k * (y.xy - at * y.z);
  float a = dx.x * dx.x + dy.x * dy.x, b = dx.x * dx.y + dy.x * dy.y, c = dx.y * dx.y + dy.y * dy.y;
  float larger = 0.5 * (a + c) + length(vec2(0.5 * (a - c), b)), det = dx.x * dy.y - dy.x * dx.y;
  return det * det / max(larger, 1e-12);
}

// How wide a photograph's pixels are in the view, px: the longer axis of their projections (Eq. 9.4-9.6).
float pixel_spacing(int slot, vec2 window_pixel, vec4 surface) {
  return inversesqrt(max(footprint(listed(slot), window_pixel, surface.xyz, surface.w), 1e-12));
}

// The footprint in a listed photograph, 0 where no pixel of this view needs its smaller levels.
float footprint_if_deep(int slot, vec2 window_pixel, vec4 surface) {
  if (view.camera_fade[slot].z == 0.0) return 0.0;
  return footprint(listed(slot), window_pixel, surface.xyz, surface.w);
}

// The level that is read for a footprint, and the share of the next.
int level_mix(float area, out float next) {
  area = max(area / kSharpArea, 1.0);
  int level = 0;
  while (area >= 4.0 && level < kLastLevel) {
    area *= 0.25;
    ++level;
  }
  next = level == kLastLevel ? 0.0 : (area - 1.0) / 3.0;
  return level;
}

vec3 photo_color(int index, vec2 pixel, float area) {
  float next;
  int level = level_mix(area, next), levels = next > 0.0 ? 2 : 1;
  vec3 sum = vec3(0.0);
  for (int k = 0; k < levels; ++k)
    sum += (k == 0 ? 1.0 - next : next) * photo_color_at(index, pixel, level + k);
  return sum;
}

vec4 photo(int index, vec2 pixel, float area) {
  float next;
  int level = level_mix(area, next), levels = next > 0.0 ? 2 : 1;
  vec4 sum = vec4(0.0);
  for (int k = 0; k < levels; ++k) sum += (k == 0 ? 1.0 - next : next) * photo_at(index, pixel, level + k);
  return sum;
}
