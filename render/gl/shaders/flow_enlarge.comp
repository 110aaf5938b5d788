// Takes a field to the next finer level, bilinearly; displacements double (enlargement.cpp).
layout(binding = 1) uniform sampler2DArray coarse;
layout(binding = 2) uniform usampler2D spans;
layout(binding = 0) writeonly uniform image2DArray fine;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 coarse_size;

const float kNear = 0.75, kFar = 0.25;

void main() {
  ivec2 tile;
  int field;
  if (!work(tile, field)) return;
  for (int k = 0; k < kRowsEach; ++k) {
    ivec2 at = pixel_of(tile, k);
    if (any(greaterThanEqual(at, size))) continue;
    ivec2 span = ivec2(texelFetch(spans, ivec2(at.y, tables.fields[field].x), 0).xy);
    vec2 uv = vec2(0.0);
    if (at.x >= span.x && at.x < span.y) {
      ivec2 near = at / 2, far = clamp(near + 2 * (at & 1) - 1, ivec2(0), coarse_size - 1);
      vec2 a = 2.0 * texelFetch(coarse, ivec3(near, field), 0).xy;
      vec2 b = 2.0 * texelFetch(coarse, ivec3(near.x, far.y, field), 0).xy;
      vec2 c = 2.0 * texelFetch(coarse, ivec3(far.x, near.y, field), 0).xy;
      vec2 d = 2.0 * texelFetch(coarse, ivec3(far, field), 0).xy;
      uv = kNear * (kNear * a + kFar * b) + kFar * (kNear * c + kFar * d);
    }
    imageStore(fine, ivec3(at, field), vec4(uv, 0.0, 0.0));
  }
}
