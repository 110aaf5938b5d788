// The last filling, at full size; displacements that the flow invents become zero (pairwise_flows.cpp).
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray fine;
layout(binding = 2) uniform sampler2DArray coarse;
layout(binding = 0) writeonly uniform image2DArray flow;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 coarse_size;

const float kNoise = 0.15, kCertain = 0.45;  // px

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, size))) return;
  vec2 uv = filled(fine, coarse, at, coarse_size);
  float square = dot(uv, uv);
  if (square < kCertain * kCertain)
    uv *= square <= kNoise * kNoise ? 0.0 : min((sqrt(square) - kNoise) / (kCertain - kNoise), 1.0);
  imageStore(flow, at, vec4(uv, 0.0, 0.0));
}
