// Photographs filtered along their lines of disparity, then blended (ch. 10). The twin of
// render/cpu/filtered_renderer.cpp and render/photo_pyramid.cpp.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform sampler2DArray pyramid[5];  // a half of the size, a quarter …
layout(location = 0) uniform ivec2 window_in_target;
layout(location = 1) uniform float error;  // m along the viewing ray
layout(location = 0) out vec4 color;

const float kFaint = 1e-4, kLeastShare = 0.25, kNearest = 0.1, kReach = 2.0, kWidestTaps = 64.0;
const float kWidestSharp = 2.0;
const int kLevels = 5, kFewTaps = 4;

float mitchell(float x) {
  x = abs(x);
  if (x < 1.0) return (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0;
  return x < 2.0 ? (((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0) / 6.0 : 0.0;
}

vec4 at_level(int level, vec3 place) {
  if (level == 1) return textureLod(pyramid[0], place, 0.0);
  if (level == 2) return textureLod(pyramid[1], place, 0.0);
  if (level == 3) return textureLod(pyramid[2], place, 0.0);
  return level == 4 ? textureLod(pyramid[3], place, 0.0) : textureLod(pyramid[4], place, 0.0);
}

vec2 level_size(int level) {
  return vec2(level == 1 ? textureSize(pyramid[0], 0).xy : level == 2 ? textureSize(pyramid[1], 0).xy
              : level == 3 ? textureSize(pyramid[2], 0).xy
              : level == 4 ? textureSize(pyramid[3], 0).xy : textureSize(pyramid[4], 0).xy);
}

// Colour and opacity at a place of the photograph, from a level of its pyramid.
vec4 read(int index, vec2 pixel, int level, bool sharp) {
  if (level == 0) {
    vec4 soft = photo(index, pixel);
    return sharp ? vec4(photo_color(index, pixel), soft.a) : soft;
  }
  vec4 tile = cameras[index].tile;
  vec2 size = tile.zw;
  for (int i = 0; i < level; ++i) size = floor((size + 1.0) * 0.5);
  pixel = clamp((pixel - tile.xy) * exp2(-float(level)), vec2(0.5), size - 0.5);
  return at_level(level, vec3(pixel / level_size(level), cameras[index].image.z));
}

vec3 filtered(int slot, vec2 window_pixel, float z, float ray_length) {
  int index = listed(slot);
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
  while (narrow > kWidestTaps && level < kLevels) {
    narrow *= 0.5;
    ++level;
  }
  int few = clamp(int(ceil(float(kFewTaps) * width)), 1, kFewTaps);
  int taps = clamp(int(ceil(narrow)), few, int(kWidestTaps));
  vec2 gap = way * (2.0 * kReach / float(taps));
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int tap = 0; tap < taps; ++tap) {
    float place = float(tap) + 0.5 - 0.5 * float(taps), w = mitchell(2.0 * kReach * place / float(taps));
    vec4 c = read(index, middle + place * gap, level, width <= kWidestSharp);
    sum += w * vec4(c.rgb * c.a, c.a);
    total += w;
  }
  if (sum.a < kLeastShare * total) return photo_color(index, middle);
  return clamp(sum.rgb / sum.a, 0.0, 1.0);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - window_in_target;
  float z = texelFetch(surface, at, 0).w;
  if (z >= kNothing) discard;
  vec2 pixel = vec2(at) + 0.5;
  float ray_length = length(view_ray(pixel)), total = 0.0;
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  vec3 sum = vec3(0.0), colors[kMaxListed];
  for (int slot = 0; slot < view.counts.x; ++slot) {
    float w = slot < 4 ? w0[slot] : w1[slot - 4];
    if (w < kFaint) continue;
    colors[slot] = filtered(slot, pixel, z, ray_length);
    sum += w * colors[slot];
    total += w;
  }
  vec3 mean = sum / max(total, 1e-6);
  color = vec4(mean, 1.0);
  if (view.counts.w == kGhosting) {
    float apart = 0.0;
    for (int slot = 0; slot < view.counts.x; ++slot) {
      float w = slot < 4 ? w0[slot] : w1[slot - 4];
      if (w >= kFaint) apart += w / total * distance(colors[slot], mean);
    }
    color.rgb = heat(3.0 * apart);
  }
}
