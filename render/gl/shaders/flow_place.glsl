// Where a kernel that computes one pixel an invocation over listed tiles of 32x32 is: 32x8 invocations, four rows each.
layout(local_size_x = 32, local_size_y = 8) in;
const int kTile = 32, kRowsEach = 4;

ivec2 pixel_of(ivec2 tile, int k) {
  return tile * kTile + ivec2(gl_LocalInvocationID.xy) + ivec2(0, 8 * k);
}
