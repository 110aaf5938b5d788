// Photographs filtered along their lines of disparity, then blended (ch. 10). The twin of
// render/cpu/filtered_renderer.cpp and render/photo_pyramid.cpp.
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(location = 1) uniform float error;  // m along the viewing ray

const float kFaint = 1e-4, kLeastShare = 0.25, kNearest = 0.1, kReach = 2.0, kWidestTaps = 64.0;
const float kWidestSharp = 2.0;
const int kFewTaps = 4;

float mitchell(float x) {
  x = abs(x);
  if (x < 1.0) return (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0;
  return x < 2.0 ? (((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0) / 6.0 : 0.0;
}

// Colour and opacity at a place of the photograph, from the levels that `area` asks for.
vec4 read(int slot, vec2 pixel, float area, bool sharp) {
  int index = listed(slot);
  vec4 soft = photo(index, pixel, area);
  return sharp ? vec4(photo_color(index, pixel, area), soft.a) : soft;
}

vec3 filtered(int slot, vec2 window_pixel, vec4 here, float ray_length) {
  int index = listed(slot);
  float z = here.w;
  mat4 to_camera = cameras[index].cam_from_world;
  float along = error / ray_length;
  vec2 middle, p1, p2, way = vec2(0.0);
  photo_pixel(index, (to_camera * vec4(world_at(window_pixel, z), 1.0)).xyz, middle);
  photo_pixel(index, (to_camera * vec4(world_at(window_pixel, max(z - along, kNearest * z)), 1.0)).xyz, p1);
  photo_pixel(index, (to_camera * vec4(world_at(window_pixel, z + along), 1.0)).xyz, p2);
  if (p1 != vec2(-1.0) && p2 != vec2(-1.0)) {
    middle = 0.5 * (p1 + p2);
    way = p2 - p1;
  }
  float width = 2.0 * kReach * length(way), narrow = width;
  int level = 0;
  while (narrow > kWidestTaps && level < kLastLevel) {
    narrow *= 0.5;
    ++level;
  }
  int few = clamp(int(ceil(float(kFewTaps) * width)), 1, kFewTaps);
  int taps = clamp(int(ceil(narrow)), few, int(kWidestTaps));
  // A level alone is what a footprint of its pixels' size reads.
  float own = footprint_if_deep(slot, window_pixel, here), area = own;
  if (level > 0) area = max(own, kSharpArea * exp2(2.0 * float(level)));
  vec2 gap = way * (2.0 * kReach / float(taps));
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int tap = 0; tap < taps; ++tap) {
    float place = float(tap) + 0.5 - 0.5 * float(taps), w = mitchell(2.0 * kReach * place / float(taps));
    vec4 c = read(slot, middle + place * gap, area, width <= kWidestSharp);
    sum += w * vec4(c.rgb * c.a, c.a);
    total += w;
  }
  if (sum.a < kLeastShare * total) return photo_color(index, middle, own);
  return clamp(sum.rgb / sum.a, 0.0, 1.0);
}

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec2 pixel = vec2(at) + 0.5;
  float ray_length = length(view_ray(pixel)), total = 0.0;
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  vec3 sum = vec3(0.0), colors[kMaxListed];
  for (int slot = 0; slot < view.counts.x; ++slot) {
    float w = slot < 4 ? w0[slot] : w1[slot - 4];
    if (w < kFaint) continue;
    colors[slot] = filtered(slot, pixel, here, ray_length);
    sum += w * colors[slot];
    total += w;
  }
  vec3 mean = sum / max(total, 1e-6);
  vec4 color = vec4(mean, 1.0);
  if (view.counts.w == kGhosting) {
    float apart = 0.0;
    for (int slot = 0; slot < view.counts.x; ++slot) {
      float w = slot < 4 ? w0[slot] : w1[slot - 4];
      if (w >= kFaint) apart += w / total * distance(colors[slot], mean);
    }
    color.rgb = heat(3.0 * apart);
  }
  draw(color);
}
