// The finest level of a pyramid: (1 2 1)/4 in both directions over what lies in the domain (picture_filters.cpp).
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform usampler2DArray gray_and_state;
layout(binding = 0) writeonly uniform image2DArray value;
layout(binding = 1) writeonly uniform uimage2DArray zone_and_own;
layout(location = 0) uniform ivec2 size;

const float kWeights[3] = float[](1.0, 2.0, 1.0);

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, size))) return;
  float total = 0.0, weight = 0.0;
  for (int i = 0; i < 3; ++i) {
    float sum = 0.0, known = 0.0;
    for (int k = 0; k < 3; ++k) {
      ivec2 p = at.xy + ivec2(i, k) - 1;
      if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) continue;
      uvec2 raw = texelFetch(gray_and_state, ivec3(p, at.z), 0).xy;
      float w = raw.y != 0u ? kWeights[k] : 0.0;
      sum += w * float(raw.x);
      known += w;
    }
    total += kWeights[i] * sum;
    weight += kWeights[i] * known;
  }
  uint state = texelFetch(gray_and_state, at, 0).y;
  imageStore(value, at, vec4(total / max(weight, 1.0), 0.0, 0.0, 0.0));
  imageStore(zone_and_own, at, uvec4(state != 0u ? 2u : 0u, state == 255u ? 255u : 0u, 0u, 0u));
}
