// Weights, visibility, soft visibility or depth instead of the picture.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform usampler2D visibility;
layout(binding = 5) uniform sampler2D soft0;
layout(binding = 6) uniform sampler2D soft1;
layout(location = 0) uniform ivec2 window_in_target;
layout(location = 1) uniform vec2 depth_range;
layout(location = 0) out vec4 color;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - window_in_target;
  float z = texelFetch(surface, at, 0).w;
  if (z >= kNothing) discard;
  if (view.counts.w == kDepth) {
    color = vec4(vec3(1.0 - clamp((z - depth_range.x) / (depth_range.y - depth_range.x), 0.0, 1.0)), 1.0);
    return;
  }
  if (view.counts.w == kOpacity) {  // outline.frag draws it
    color = vec4(1.0);
    return;
  }
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  vec4 s0 = texelFetch(soft0, at, 0), s1 = texelFetch(soft1, at, 0);
  uint seen = texelFetch(visibility, at, 0).x;
  vec3 sum = vec3(0.0);
  int shown = view.counts.w == kWeights ? view.counts.x : view.counts.y;
  for (int slot = 0; slot < shown; ++slot) {
    float amount = view.counts.w == kWeights ? (slot < 4 ? w0[slot] : w1[slot - 4])
                   : view.counts.w == kVisibility ? float(seen >> slot & 1u) / float(shown)
                                                  : (slot < 4 ? s0[slot] : s1[slot - 4]) / float(shown);
    sum += amount * camera_color(listed(slot));
  }
  color = vec4(sum, 1.0);
}
