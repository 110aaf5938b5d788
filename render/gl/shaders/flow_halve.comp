// The next level of a pyramid: (1 3 3 1)/8 around each pair in both directions over what lies in the domain; evidence
// is the share of it (picture_filters.cpp).
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray fine_value;
layout(binding = 2) uniform usampler2DArray fine_zone_and_own;
layout(binding = 0) writeonly uniform image2DArray value;
layout(binding = 1) writeonly uniform uimage2DArray zone_and_own;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 fine_size;

const uint kDomain = 2u;
const float kWeights[4] = float[](1.0, 3.0, 3.0, 1.0);

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, size))) return;
  float total = 0.0, weight = 0.0;
  uint count = 0u, own = 0u;
  for (int i = 0; i < 4; ++i) {
    float sum = 0.0, known = 0.0;
    for (int k = 0; k < 4; ++k) {
      ivec2 p = 2 * at.xy + ivec2(i, k) - 1;
      if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, fine_size))) continue;
      uvec2 facts = texelFetch(fine_zone_and_own, ivec3(p, at.z), 0).xy;
      if (facts.x != kDomain) continue;
      sum += kWeights[k] * texelFetch(fine_value, ivec3(p, at.z), 0).x;
      known += kWeights[k];
      if (i == 0 || i == 3 || k == 0 || k == 3) continue;
      ++count;
      own += facts.y;
    }
    total += kWeights[i] * sum;
    weight += kWeights[i] * known;
  }
  imageStore(value, at, vec4(total / max(weight, 1.0), 0.0, 0.0, 0.0));
  imageStore(zone_and_own, at, uvec4(count > 0u ? kDomain : 0u, count > 0u ? own / count : 0u, 0u, 0u));
}
