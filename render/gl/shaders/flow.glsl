// What the kernels of the flow share. Mirrors Tables in render/gl/flow_tables.h.
const int kMostPictures = 8, kMostFields = 64;

layout(std430, binding = 1) readonly buffer Tables {
  ivec4 fields[kMostFields];    // x: the picture looked from, y: the one looked into, z: the field of the way back or -1
  int from[kMostPictures * 8];  // [8 picture + k]: the k-th field that looks from a picture, or -1
} tables;

// The tiles of one level that hold something of the proxy (flow_tiles.comp); `groups` is what is dispatched.
layout(std430, binding = 2) buffer Tiles {
  uint groups[3];
  uint count;
  uint tiles[];
} listed;
const uint kGroupsInARow = 32768u;

// The tile and field of this work group. False: there is none.
bool work(out ivec2 tile, out int field) {
  uint index = gl_WorkGroupID.y * kGroupsInARow + gl_WorkGroupID.x;
  if (index >= listed.count) return false;
  uint packed_tile = listed.tiles[index];
  tile = ivec2(packed_tile & 1023u, packed_tile >> 10 & 1023u);
  field = tables.from[8 * int(packed_tile >> 20) + int(gl_WorkGroupID.z)];
  return field >= 0;
}
