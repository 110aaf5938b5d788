// Per row and picture the columns [x, y) that the solver works on, in whole blocks (PictureLevel::spans).
layout(local_size_x = 64) in;
layout(binding = 1) uniform sampler2DArray stiffness_and_data;
layout(binding = 0) writeonly uniform uimage2D spans;  // x: row, y: picture
layout(location = 0) uniform int width;

const int kBlock = 32;  // columns: two halves of kSplitBlock
shared int first, last;

void main() {
  ivec2 row_and_picture = ivec2(gl_WorkGroupID.xy);
  if (gl_LocalInvocationIndex == 0u) {
    first = width;
    last = -1;
  }
  synchronize();
  for (int x = int(gl_LocalInvocationIndex); x < width; x += 64)
    if (texelFetch(stiffness_and_data, ivec3(x, row_and_picture), 0).x > 0.0) {
      atomicMin(first, x);
      atomicMax(last, x);
    }
  synchronize();
  if (gl_LocalInvocationIndex != 0u) return;
  uvec2 span = last < 0 ? uvec2(0u) : uvec2(first / kBlock * kBlock, (last / kBlock + 1) * kBlock);
  imageStore(spans, row_and_picture, uvec4(span, 0u, 0u));
}
