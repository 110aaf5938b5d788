// What all renderers can show instead of the picture. The twin of render/cpu/inspection.cpp.
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform usampler2D visibility;
layout(binding = 5) uniform sampler2D soft0;
layout(binding = 6) uniform sampler2D soft1;
layout(location = 1) uniform vec2 depth_range;
layout(location = 2) uniform int shown;           // slot of the photograph to show; -1: none
layout(location = 3) uniform float depth_error;   // m along the viewing ray

const float kFaintWeight = 1e-4;

float weights[kMaxListed];

vec3 photograph(vec2 middle, vec4 here, uint seen) {
  vec2 pixel;
  if (shown < 0 || (seen >> shown & 1u) == 0u) return vec3(0.0);
  int index = listed(shown);
  vec3 world = world_at(middle, here.w);
  if (!photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel)) return vec3(0.0);
  return photo_color(index, pixel, footprint_if_deep(shown, middle, here));
}

vec3 aliasing(vec2 middle, vec4 here) {
  float sum = 0.0, total = 0.0;
  for (int slot = 0; slot < view.counts.x; ++slot) {
    sum += weights[slot] * pixel_spacing(slot, middle, here);
    total += weights[slot];
  }
  return spacing_color(total > 0.0 ? sum / total : 1.0);
}

vec3 predicted(vec2 middle, vec4 here) {
  mat3 view_from_world = transpose(mat3(view.world_from_view));
  vec3 ray = view_ray(middle), n = view_from_world * here.xyz;
  float scale = depth_error / length(ray) * abs(dot(n, ray)) / here.w, spacing[kMaxListed];
  vec2 shift[kMaxListed];
  int worst = kSharp;
  for (int a = 0; a < view.counts.x; ++a) {
    shift[a] = view.view_k.xy * scale * parallax(a, ray, ray * here.w, n, view_from_world);
    spacing[a] = pixel_spacing(a, middle, here);
    if (weights[a] < kFaintWeight) continue;
    for (int b = 0; b <= a; ++b)
      if (weights[b] >= kFaintWeight)
        worst = max(worst, blend_class(distance(shift[a], shift[b]), spacing[a], spacing[b]));
  }
  return class_color(worst);
}

// Weights or visibilities, in the cameras' colours.
vec3 amounts(ivec2 at, uint seen) {
  vec4 s0 = texelFetch(soft0, at, 0), s1 = texelFetch(soft1, at, 0);
  vec3 sum = vec3(0.0);
  int count = view.counts.w == kWeights ? view.counts.x : view.counts.y;
  for (int slot = 0; slot < count; ++slot) {
    float amount = view.counts.w == kWeights      ? weights[slot]
                   : view.counts.w == kVisibility ? float(seen >> slot & 1u) / float(count)
                                                  : (slot < 4 ? s0[slot] : s1[slot - 4]) / float(count);
    sum += amount * camera_color(listed(slot));
  }
  return sum;
}

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec2 middle = vec2(at) + 0.5;
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  for (int slot = 0; slot < kMaxListed; ++slot) weights[slot] = slot < 4 ? w0[slot] : w1[slot - 4];
  uint seen = texelFetch(visibility, at, 0).x;
  int wanted = view.counts.w;
  vec3 rgb = wanted == kDepth       ? vec3(1.0 - clamp((here.w - depth_range.x) / (depth_range.y - depth_range.x), 0.0, 1.0))
             : wanted == kOpacity   ? vec3(1.0)  // outline.comp draws it
             : wanted == kProjected ? photograph(middle, here, seen)
             : wanted == kAliasing  ? aliasing(middle, here)
             : wanted == kPredicted ? predicted(middle, here)
                                    : amounts(at, seen);
  draw(vec4(rgb, 1.0));
}
