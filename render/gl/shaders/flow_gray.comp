// The projected images as the flow wants them: grey and where the colour comes from, at 1/shrink of their size
// (render/projected_images.cpp).
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray images;  // RGBA8; alpha: see project.comp
layout(binding = 0) writeonly uniform uimage2DArray gray_and_state;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 full_size;
layout(location = 2) uniform int shrink;

void main() {
  ivec3 at = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(at.xy, size))) return;
  uint sum = 0u, count = 0u, least = 255u;
  ivec2 low = at.xy * shrink, high = min(low + shrink, full_size);
  for (int y = low.y; y < high.y; ++y)
    for (int x = low.x; x < high.x; ++x) {
      uvec4 c = uvec4(texelFetch(images, ivec3(x, y, at.z), 0) * 255.0 + 0.5);
      if (c.a == 0u) continue;
      sum += (77u * c.r + 150u * c.g + 29u * c.b + 128u) >> 8;
      least = min(least, c.a);
      ++count;
    }
  uint gray = count > 0u ? (sum + count / 2u) / count : 0u;
  uint state = count == 0u ? 0u : least > 192u ? 255u : 128u;
  imageStore(gray_and_state, at, uvec4(gray, state, 0u, 0u));
}
