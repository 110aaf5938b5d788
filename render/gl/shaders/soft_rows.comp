// First pass of the distance filter (Eq. 11.5): per listed camera the distance along the row to the next pixel of the
// proxy that it does not see, a byte each; 255 is "none within the radius". Of hidden pixels those count most of whose
// nine neighbours (with themselves) are hidden, too: a speck of one or two comes and goes from view to view, and would
// take a camera's weight from a whole circle.
layout(local_size_x = 32, local_size_y = 8) in;
layout(binding = 1) uniform usampler2D visibility;
layout(binding = 0) writeonly uniform uimage2D row_distances;

const int kMostReach = 64;  // px: RendererOptions::soft_radius's largest
const int kWide = 32, kHigh = 8, kWidest = kWide + 2 * kMostReach;

shared uint hidden[kHigh * kWidest];  // a bit a listed camera, of the group's rows and `reach` px on both sides

uint unseen(ivec2 at) {
  if (!in_window(at)) return 0u;
  uvec2 v = texelFetch(visibility, at, 0).xy;
  return v.y == 0u ? 0u : ~v.x & (1u << view.counts.x) - 1u;
}

// Those cameras of `here`, which do not see a pixel, that do not see most of what is around it.
uint without_specks(ivec2 at, uint here) {
  int count[kMaxListed];
  for (int slot = 0; slot < kMaxListed; ++slot) count[slot] = 0;
  for (int k = 0; k < 9; ++k) {
    uint there = unseen(at + ivec2(k % 3, k / 3) - 1);
    for (int slot = 0; slot < view.counts.x; ++slot) count[slot] += int(there >> slot & 1u);
  }
  uint kept = 0u;
  for (int slot = 0; slot < view.counts.x; ++slot)
    if (count[slot] > 4) kept |= here & 1u << slot;
  return kept;
}

// Puts a distance into the byte of each camera of `found`.
void note(uint found, uint distance_to, inout uvec2 distances) {
  for (int slot = 0; slot < view.counts.x; ++slot) {
    if ((found >> slot & 1u) == 0u) continue;
    uint shift = uint(slot & 3) * 8u;
    if (slot < 4)
      distances.x = distances.x & ~(255u << shift) | distance_to << shift;
    else
      distances.y = distances.y & ~(255u << shift) | distance_to << shift;
  }
}

void main() {
  int reach = int(ceil(view.settings.y)), wide = kWide + 2 * reach;
  ivec2 origin = ivec2(gl_WorkGroupID.xy) * ivec2(kWide, kHigh) - ivec2(reach, 0);
  for (int i = int(gl_LocalInvocationIndex); i < kHigh * wide; i += kWide * kHigh) {
    ivec2 local = ivec2(i % wide, i / wide);
    uint here = unseen(origin + local);
    hidden[local.y * kWidest + local.x] = here == 0u ? 0u : without_specks(origin + local, here);
  }
  synchronize();
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (!in_window(at)) return;
  int middle = int(gl_LocalInvocationID.y) * kWidest + int(gl_LocalInvocationID.x) + reach;
  uint todo = (1u << view.counts.x) - 1u;
  uvec2 distances = uvec2(0xffffffffu);
  for (int d = 0; d <= reach && todo != 0u; ++d) {
    uint found = (hidden[middle - d] | hidden[middle + d]) & todo;
    if (found == 0u) continue;
    todo &= ~found;
    note(found, uint(d), distances);
  }
  imageStore(row_distances, at, uvec4(distances, 0u, 0u));
}
