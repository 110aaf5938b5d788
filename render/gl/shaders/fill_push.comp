// Fills what a level does not know from the coarser one.
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray fine;
layout(binding = 2) uniform sampler2DArray coarse;
layout(binding = 0) writeonly uniform image2DArray whole;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 coarse_size;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, size))) return;
  imageStore(whole, at, vec4(filled(fine, coarse, at, coarse_size), 1.0, 0.0));
}
