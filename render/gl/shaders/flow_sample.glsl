// A picture read where a displacement points to: brightness, and 1 where all that is read is evidence. Values go on
// beyond the border, evidence does not (flow_kernels_scalar.cpp).
const float kSampleStep = 1.0 / 256.0;  // of a sample without its lowest bit

uint tap(usampler2DArray samples, ivec2 p, ivec2 size, int picture) {
  ivec2 inside = clamp(p, ivec2(0), size - 1);
  uint s = texelFetch(samples, ivec3(inside, picture), 0).x;
  return inside == p ? s : s & 0xFFFEu;
}
float value_of(uint s) { return float(s & 0xFFFEu); }

vec2 bilinear(usampler2DArray samples, ivec2 p, vec2 f, ivec2 size, int picture) {
  uint s00 = tap(samples, p, size, picture), s10 = tap(samples, p + ivec2(1, 0), size, picture);
  uint s01 = tap(samples, p + ivec2(0, 1), size, picture), s11 = tap(samples, p + 1, size, picture);
  float a = value_of(s00) + f.x * (value_of(s10) - value_of(s00));
  float b = value_of(s01) + f.x * (value_of(s11) - value_of(s01));
  return vec2((a + f.y * (b - a)) * kSampleStep, float(s00 & s10 & s01 & s11 & 1u));
}

// Catmull-Rom at t in [0, 1): exactly (0, 1, 0, 0) at 0.
vec4 cubic_weights(float t) {
  float t2 = t * t, t3 = t2 * t;
  return vec4(0.5 * ((t2 + t2) - (t + t3)), 1.0 + (1.5 * t3 - 2.5 * t2), 0.5 * ((4.0 * t2 + t) - 3.0 * t3),
              0.5 * (t3 - t2));
}

vec2 cubic(usampler2DArray samples, ivec2 p, vec2 f, ivec2 size, int picture) {
  vec4 wx = cubic_weights(f.x), wy = cubic_weights(f.y);
  float sum = 0.0;
  uint known = 1u;
  for (int j = 0; j < 4; ++j) {
    float row = 0.0;
    for (int i = 0; i < 4; ++i) {
      uint s = tap(samples, p + ivec2(i, j) - 1, size, picture);
      row += wx[i] * value_of(s);
      if ((i == 1 || i == 2) && (j == 1 || j == 2)) known &= s;
    }
    sum += wy[j] * row;
  }
  return vec2(sum * kSampleStep, float(known & 1u));
}
