// Lists the tiles of a level that hold domain or band, or touch it: nothing else is computed.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1) uniform sampler2DArray stiffness_and_data;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform int side;

shared uint found;

void main() {
  int picture = int(gl_WorkGroupID.z);
  if (tables.from[8 * picture] < 0) return;
  if (gl_LocalInvocationIndex == 0u) found = 0u;
  synchronize();
  ivec2 low = max(ivec2(gl_WorkGroupID.xy) * side - 1, ivec2(0));
  ivec2 high = min((ivec2(gl_WorkGroupID.xy) + 1) * side + 1, size);
  bool any_here = false;
  for (int y = low.y + int(gl_LocalInvocationID.y); y < high.y && !any_here; y += 8)
    for (int x = low.x + int(gl_LocalInvocationID.x); x < high.x && !any_here; x += 8)
      any_here = texelFetch(stiffness_and_data, ivec3(x, y, picture), 0).x > 0.0;
  if (any_here) atomicOr(found, 1u);
  synchronize();
  if (gl_LocalInvocationIndex != 0u || found == 0u) return;
  uint index = atomicAdd(listed.count, 1u);
  listed.tiles[index] = gl_WorkGroupID.x | gl_WorkGroupID.y << 10 | uint(picture) << 20;
  atomicMax(listed.groups[0], min(index + 1u, kGroupsInARow));
  atomicMax(listed.groups[1], index / kGroupsInARow + 1u);
}
