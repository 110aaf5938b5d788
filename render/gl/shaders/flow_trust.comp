// How far is the flow to be believed (flow_trust.cpp)? Both pictures must have their own colour at both ends; the farther
// from home the way back leads and the less the flow makes them agree, the less the field is known.
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray field_uv;
layout(binding = 2) uniform usampler2DArray gray_and_state;
layout(binding = 3) uniform usampler2DArray zone_and_own;
layout(binding = 0) writeonly uniform image2DArray believed;  // u, v, how far; or 0
layout(location = 0) uniform ivec2 size;

const uint kOwn = 255u, kDomain = 2u;
const float kUsualRoundTrip = 0.7;  // px; these as in flow_trust.cpp
const float kUsualResidual = 10.0;  // 8-bit steps
const int kReach = 2, kAcross = 2 * kReach + 1, kSide = 16 + 2 * kReach;

shared float still[kSide * kSide], moved[kSide * kSide];

// The field as it is handed out: 0 outside the domain.
vec2 uv_at(ivec2 p, int field) {
  if (texelFetch(zone_and_own, ivec3(p, tables.fields[field].x), 0).x != kDomain) return vec2(0.0);
  return texelFetch(field_uv, ivec3(p, field), 0).xy;
}

float gray(ivec2 p, int picture) { return float(texelFetch(gray_and_state, ivec3(p, picture), 0).x); }

float bilinear(vec2 at, int picture) {
  at = clamp(at, vec2(0.0), vec2(size - 1));
  ivec2 low = ivec2(at), high = min(low + 1, size - 1);
  vec2 f = at - vec2(low);
  float top = gray(low, picture) * (1.0 - f.x) + gray(ivec2(high.x, low.y), picture) * f.x;
  float bottom = gray(ivec2(low.x, high.y), picture) * (1.0 - f.x) + gray(high, picture) * f.x;
  return top * (1.0 - f.y) + bottom * f.y;
}

// All without a fault, half where it is usual, nothing from twice that on.
float share(float fault, float usual) { return fault < 2.0 * usual ? 1.0 - fault / (2.0 * usual) : fault > 0.0 ? 0.0 : 1.0; }

float confidence(ivec2 p, int me, vec2 uv, ivec4 pair, int field) {
  if (texelFetch(gray_and_state, ivec3(p, pair.x), 0).y != kOwn) return 0.0;
  if (texelFetch(gray_and_state, ivec3(p, pair.y), 0).y != kOwn) return 0.0;
  float before = 0.0, after = 0.0;
  for (int v = 0; v < kAcross; ++v)
    for (int u = 0; u < kAcross; ++u) {
      before += still[me + v * kSide + u];
      after += moved[me + v * kSide + u];
    }
  float agrees = share(after, kUsualResidual * float(kAcross * kAcross)) * share(after, before);
  vec2 to = vec2(p) + uv + 0.5;
  if (agrees <= 0.0 || any(lessThan(to, vec2(0.0))) || any(greaterThanEqual(to, vec2(size)))) return 0.0;
  ivec2 end = ivec2(to);
  if (texelFetch(gray_and_state, ivec3(end, pair.y), 0).y != kOwn) return 0.0;
  if (pair.z >= 0) agrees *= share(length(uv + uv_at(end, pair.z)), kUsualRoundTrip);
  return floor(255.0 * agrees + 0.5) / 255.0;
}

void main() {
  int field = int(gl_WorkGroupID.z);
  ivec4 pair = tables.fields[field];
  ivec2 origin = ivec2(gl_WorkGroupID.xy) * 16 - kReach;
  for (int i = int(gl_LocalInvocationIndex); i < kSide * kSide; i += 256) {
    ivec2 p = origin + ivec2(i % kSide, i / kSide);
    bool inside = pair.w != 0 && all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
    float here = inside ? gray(p, pair.x) : 0.0;
    still[i] = inside ? abs(here - gray(p, pair.y)) : 0.0;
    moved[i] = inside ? abs(here - bilinear(vec2(p) + uv_at(p, field), pair.y)) : 0.0;
  }
  synchronize();
  ivec2 at = origin + kReach + ivec2(gl_LocalInvocationID.xy);
  if (any(greaterThanEqual(at, size))) return;
  vec2 uv = pair.w != 0 ? uv_at(at, field) : vec2(0.0);
  // A field that nobody asked for is zero everywhere, and known to be.
  int me = int(gl_LocalInvocationID.y) * kSide + int(gl_LocalInvocationID.x);
  float known = pair.w == 0 ? 1.0 : confidence(at, me, uv, pair, field);
  imageStore(believed, ivec3(at, field), known > 0.0 ? vec4(uv, known, 0.0) : vec4(0.0));
}
