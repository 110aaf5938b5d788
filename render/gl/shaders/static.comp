// Floating Textures for scenes at rest (Eq. 11.4): photographs displaced by fields that were estimated in the cameras'
// own pictures, and blended. The twin of render/cpu/static_renderer.cpp and field_kernels.cpp.
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform sampler2D angular0;
layout(binding = 5) uniform sampler2D angular1;
layout(binding = 6) uniform sampler2DArray fields;
layout(location = 1) uniform int positions;  // 0: parallax cancels, 1: the angular mean
layout(std430, binding = 1) readonly buffer Grids {
  vec4 place[kMaxListed];  // px of the grid = xy * (x/z, y/z) + zw
  vec4 size[kMaxListed];   // its width and height
  int layer[kMaxListed * kMaxListed];  // of the field from slot i to slot j at 8 i + j; -1: nothing moves
} grids;

const int kInversions = 2;
const float kFaint = 1e-4, kLeastFade = 1e-4, kOffSubject = 0.1;
const float kSteps = 32767.0 / 64.0;  // CameraField::kStep

float pull[kMaxListed];    // how much each camera counts: angular weights, visible or not
float follow[kMaxListed];  // how much its idea of a position counts

// Where the fields move what photograph i shows at a place of its grid, px of the grid.
vec2 combined(int i, vec2 at) {
  at = clamp(at, vec2(0.5), grids.size[i].xy - 0.5);
  vec2 texture_size = vec2(textureSize(fields, 0).xy), sum = vec2(0.0);
  for (int j = 0; j < view.counts.y; ++j) {
    int layer = grids.layer[kMaxListed * i + j];
    if (layer < 0 || follow[j] < kFaintShare) continue;
    sum += follow[j] * textureLod(fields, vec3(at / texture_size, layer), 0.0).xy;
  }
  return kSteps * sum;
}

// The photograph's pixel that lands at a point of the surface; `moved`: by how much.
vec2 floated(int i, vec3 world, out vec2 moved) {
  int index = listed(i);
  vec3 p = (cameras[index].cam_from_world * vec4(world, 1.0)).xyz;
  moved = vec2(0.0);
  if (i < view.counts.y && grids.size[i].x > 0.0 && p.z > 0.0) {
    vec2 at = grids.place[i].xy * (p.xy / p.z) + grids.place[i].zw;
    for (int k = 0; k < kInversions; ++k) moved = combined(i, at - moved);
    p = vec3((at - moved - grids.place[i].zw) / grids.place[i].xy, 1.0);
  }
  vec2 pixel;
  photo_pixel(index, p, pixel);
  return pixel;
}

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec2 middle = vec2(at) + 0.5;
  vec3 world = world_at(middle, here.w), sum = vec3(0.0), colors[kMaxListed];
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  vec4 a0 = texelFetch(angular0, at, 0), a1 = texelFetch(angular1, at, 0);
  int chosen = view.counts.y;
  float pull_total = 0.0, used[kMaxListed], total = 0.0, strongest = -1.0;
  for (int i = 0; i < chosen; ++i) {
    float fade = view.camera_fade[i].x;
    pull[i] = fade < kLeastFade ? 0.0 : abs(i < 4 ? a0[i] : a1[i - 4]) * fade;
    pull_total += pull[i];
  }
  for (int i = 0; i < chosen; ++i) pull[i] = pull_total > 0.0 ? pull[i] / pull_total : 1.0 / float(chosen);
  follow = pull;
  if (positions == 0) {
    vec2 u[kMaxListed];
    parallaxes(middle, here, u);
    cancel_parallax(u, follow);
  }

  vec2 strongest_warp = vec2(0.0);
  for (int i = 0; i < view.counts.x; ++i) {
    used[i] = 0.0;
    float w = i < 4 ? w0[i] : w1[i - 4];
    bool leads = i < chosen && pull[i] > strongest;
    if (w < kFaint && !leads) continue;
    vec2 moved, pixel = floated(i, world, moved);
    if (leads) {
      strongest = pull[i];
      strongest_warp = moved;
    }
    if (w < kFaint) continue;
    float area = footprint_if_deep(i, middle, here);
    colors[i] = photo_color(listed(i), pixel, area);
    // What the fields bring may lie off the subject: the point that is here does not.
    used[i] = w * (kOffSubject + photo(listed(i), pixel, area).a);
    sum += used[i] * colors[i];
    total += used[i];
  }
  vec3 mean = sum / max(total, 1e-12);
  vec4 color = vec4(mean, 1.0);
  if (view.counts.w == kFlow) {
    color.rgb = flow_color(strongest_warp);
  } else if (view.counts.w == kGhosting) {
    float apart = 0.0;
    for (int i = 0; i < view.counts.x; ++i)
      if (used[i] > 0.0) apart += used[i] / total * distance(colors[i], mean);
    color.rgb = heat(3.0 * apart);
  }
  draw(color);
}
