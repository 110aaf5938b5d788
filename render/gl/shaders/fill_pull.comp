// A coarse pixel is the mean of the known ones among its four (image_fill.cpp). Values and how much is known.
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray fine;  // u, v, weight
layout(binding = 0) writeonly uniform image2DArray coarse;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 fine_size;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, size))) return;
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 p = 2 * at.xy + ivec2(k & 1, k >> 1);
    if (any(greaterThanEqual(p, fine_size))) continue;
    vec3 one = texelFetch(fine, ivec3(p, at.z), 0).xyz;
    sum += vec3(one.xy * one.z, one.z);
  }
  imageStore(coarse, at, vec4(sum.xy / (sum.z > 0.0 ? sum.z : 1.0), min(sum.z, 1.0), 0.0));
}
