// First pass of the distance filter (Eq. 11.5): per listed camera the distance along the row to the next pixel of the
// proxy that it does not see (hidden.comp), a byte each; 255 is "none within the radius".
layout(binding = 1) uniform usampler2D hidden_pixels;
layout(binding = 0) writeonly uniform uimage2D row_distances;

uint hidden(ivec2 at) {
  return at.x < 0 || at.x >= int(view.window.z) ? 0u : texelFetch(hidden_pixels, at, 0).x;
}

void main() {
  ivec2 at = window_pixel();
  if (!in_window(at)) return;
  uint todo = (1u << view.counts.x) - 1u;
  uvec2 distances = uvec2(0xffffffffu);
  int radius = int(ceil(view.settings.y));
  for (int d = 0; d <= radius; ++d) {
    uint found = (hidden(at - ivec2(d, 0)) | hidden(at + ivec2(d, 0))) & todo;
    if (found == 0u) continue;
    todo &= ~found;
    for (int slot = 0; slot < view.counts.x; ++slot) {
      if ((found >> slot & 1u) == 0u) continue;
      uint shift = uint(slot & 3) * 8u;
      if (slot < 4)
        distances.x = distances.x & ~(255u << shift) | uint(d) << shift;
      else
        distances.y = distances.y & ~(255u << shift) | uint(d) << shift;
    }
    if (todo == 0u) break;
  }
  imageStore(row_distances, at, uvec4(distances, 0u, 0u));
}
