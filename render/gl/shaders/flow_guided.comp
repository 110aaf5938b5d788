// The same along the picture's edges: of the four coarse pixels around those count that look like the fine one (Kopf et
// al. 2007; enlargement.cpp).
layout(binding = 1) uniform sampler2DArray coarse;
layout(binding = 2) uniform usampler2D spans;
layout(binding = 3) uniform sampler2DArray coarse_value;
layout(binding = 4) uniform usampler2DArray coarse_zone_and_own;
layout(binding = 5) uniform usampler2DArray samples;
layout(binding = 0) writeonly uniform image2DArray fine;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform ivec2 coarse_size;
layout(location = 2) uniform float per_edge2;

const uint kDomain = 2u;
const float kNear = 0.75, kFar = 0.25;
const float kLeastWeight = 1e-6;  // where nothing around is known

void add(ivec2 p, int picture, int field, float share, float own, inout vec2 sum, inout float total) {
  if (texelFetch(coarse_zone_and_own, ivec3(p, picture), 0).x != kDomain) return;
  float difference = texelFetch(coarse_value, ivec3(p, picture), 0).x - own;
  float weight = share / (1.0 + difference * difference * per_edge2);
  sum += weight * 2.0 * texelFetch(coarse, ivec3(p, field), 0).xy;
  total += weight;
}

void main() {
  ivec2 tile;
  int field;
  if (!work(tile, field)) return;
  int picture = tables.fields[field].x;
  for (int k = 0; k < kRowsEach; ++k) {
    ivec2 at = pixel_of(tile, k);
    if (any(greaterThanEqual(at, size))) continue;
    ivec2 span = ivec2(texelFetch(spans, ivec2(at.y, picture), 0).xy);
    vec2 sum = vec2(0.0);
    float total = kLeastWeight;
    if (at.x >= span.x && at.x < span.y) {
      ivec2 near = at / 2, far = near + 2 * (at & 1) - 1;
      far.y = clamp(far.y, 0, coarse_size.y - 1);
      float own = float(texelFetch(samples, ivec3(at, picture), 0).x >> 1) / 128.0;
      add(near, picture, field, kNear * kNear, own, sum, total);
      add(ivec2(near.x, far.y), picture, field, kFar * kNear, own, sum, total);
      if (far.x >= 0 && far.x < coarse_size.x) {  // beyond the border nothing is known
        add(ivec2(far.x, near.y), picture, field, kNear * kFar, own, sum, total);
        add(far, picture, field, kFar * kFar, own, sum, total);
      }
    }
    imageStore(fine, ivec3(at, field), vec4(sum / total, 0.0, 0.0));
  }
}
