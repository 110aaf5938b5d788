// The pixels from which soft visibility counts its distances: hidden ones, a bit a listed camera, most of whose nine
// neighbours (with themselves) are hidden, too. A speck of one or two comes and goes from view to view, and would
// take a camera's weight from a whole circle.
layout(binding = 1) uniform usampler2D visibility;
layout(binding = 0) writeonly uniform uimage2D hidden_pixels;

uint hidden_at(ivec2 at) {
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(view.window.zw)))) return 0u;
  uvec2 v = texelFetch(visibility, at, 0).xy;
  return v.y == 0u ? 0u : ~v.x & (1u << view.counts.x) - 1u;
}

void main() {
  ivec2 at = window_pixel();
  if (!in_window(at)) return;
  uint here = hidden_at(at), hidden = 0u;
  int count[kMaxListed];
  for (int slot = 0; slot < kMaxListed; ++slot) count[slot] = 0;
  for (int dy = -1; dy <= 1 && here != 0u; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      uint there = hidden_at(at + ivec2(dx, dy));
      for (int slot = 0; slot < view.counts.x; ++slot) count[slot] += int(there >> slot & 1u);
    }
  for (int slot = 0; slot < view.counts.x; ++slot)
    if (count[slot] > 4) hidden |= here & 1u << slot;
  imageStore(hidden_pixels, at, uvec4(hidden));
}
