// A level as the solver reads it: brightness continued into a band of two pixels around the domain, rounded to 1/128
// with one bit of evidence, and the smoothness that its edges leave (picture_pyramid.cpp).
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray value;
layout(binding = 2) uniform usampler2DArray zone_and_own;
layout(binding = 0) writeonly uniform uimage2DArray samples;
layout(binding = 1) writeonly uniform image2DArray stiffness_and_data;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform vec2 stiffness_and_edge;  // PyramidOptions

const uint kOutside = 0u, kBand = 1u, kDomain = 2u;
const int kReach = 3;  // two rings of the band, and the neighbours of a gradient
const int kSide = 16 + 2 * kReach;
const float kBandStiffness = 0.01;  // picture_pyramid.cpp has the same

shared float brightness[kSide * kSide];
shared uint zones[kSide * kSide];

// What pixel `i` of the shared tile becomes when the band grows by a ring: its brightness, and 1 if it joins.
vec2 grown(int i) {
  ivec2 at = ivec2(i % kSide, i / kSide);
  if (zones[i] != kOutside || any(lessThan(at, ivec2(1))) || any(greaterThan(at, ivec2(kSide - 2)))) return vec2(0.0);
  float sum = 0.0, count = 0.0;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      int j = i + v * kSide + u;
      if (zones[j] == kOutside) continue;
      sum += brightness[j];
      count += 1.0;
    }
  return count > 0.0 ? vec2(sum / count, 1.0) : vec2(0.0);
}

void main() {
  int picture = int(gl_WorkGroupID.z), me = int(gl_LocalInvocationIndex);
  ivec2 origin = ivec2(gl_WorkGroupID.xy) * 16 - kReach;
  for (int i = me; i < kSide * kSide; i += 256) {
    ivec2 p = origin + ivec2(i % kSide, i / kSide);
    bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
    brightness[i] = inside ? texelFetch(value, ivec3(p, picture), 0).x : 0.0;
    // Beyond the picture there is nothing that a band could grow into.
    zones[i] = inside ? texelFetch(zone_and_own, ivec3(p, picture), 0).x : kOutside;
  }
  synchronize();
  for (int ring = 0; ring < 2; ++ring) {
    vec2 a = grown(me), b = me + 256 < kSide * kSide ? grown(me + 256) : vec2(0.0);
    synchronize();
    for (int turn = 0; turn < 2; ++turn) {
      int i = me + 256 * turn;
      vec2 joins = turn == 0 ? a : b;
      ivec2 p = origin + ivec2(i % kSide, i / kSide);
      if (joins.y == 0.0 || any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) continue;
      brightness[i] = joins.x;
      zones[i] = kBand;
    }
    synchronize();
  }

  ivec2 at = origin + kReach + ivec2(gl_LocalInvocationID.xy);
  if (any(greaterThanEqual(at, size))) return;
  int here = (int(gl_LocalInvocationID.y) + kReach) * kSide + int(gl_LocalInvocationID.x) + kReach;
  float dx = brightness[here + int(at.x + 1 < size.x)] - brightness[here - int(at.x > 0)];
  float dy = brightness[here + kSide * int(at.y + 1 < size.y)] - brightness[here - kSide * int(at.y > 0)];
  float edge = 1.0 / (1.0 + sqrt(dx * dx + dy * dy) * (0.5 / stiffness_and_edge.y));
  uint own = texelFetch(zone_and_own, ivec3(at, picture), 0).y;
  float of_zone = zones[here] == kDomain ? stiffness_and_edge.x
                  : zones[here] == kBand ? stiffness_and_edge.x * kBandStiffness : 0.0;
  imageStore(samples, ivec3(at, picture), uvec4(2u * uint(brightness[here] * 128.0 + 0.5) + (own >> 7)));
  imageStore(stiffness_and_data, ivec3(at, picture), vec4(edge * of_zone, float(own) / 255.0, 0.0, 0.0));
}
