// A pixel of a picture that is known in part: itself as far as it is known, its surroundings, of half the size, for the
// rest (image_fill.cpp).
vec2 filled(sampler2DArray fine, sampler2DArray coarse, ivec3 at, ivec2 coarse_size) {
  vec3 one = texelFetch(fine, at, 0).xyz;
  if (one.z >= 1.0) return one.xy;
  vec2 place = clamp(0.5 * vec2(at.xy) - 0.25, vec2(0.0), vec2(coarse_size - 1));
  ivec2 low = ivec2(place), high = min(low + 1, coarse_size - 1);
  vec2 f = place - vec2(low);
  vec2 top = texelFetch(coarse, ivec3(low, at.z), 0).xy * (1.0 - f.x) +
             texelFetch(coarse, ivec3(high.x, low.y, at.z), 0).xy * f.x;
  vec2 bottom = texelFetch(coarse, ivec3(low.x, high.y, at.z), 0).xy * (1.0 - f.x) +
                texelFetch(coarse, ivec3(high, at.z), 0).xy * f.x;
  return one.z * one.xy + (1.0 - one.z) * (top * (1.0 - f.y) + bottom * f.y);
}
