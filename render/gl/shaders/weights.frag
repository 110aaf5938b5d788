// Second pass of the distance filter, then the final weights: angular weight x soft visibility, normalised.
layout(binding = 1) uniform usampler2D visibility;
layout(binding = 2) uniform usampler2D row_distances;
layout(binding = 3) uniform sampler2D angular0_in;
layout(binding = 4) uniform sampler2D angular1_in;
layout(location = 0) out vec4 weights0;
layout(location = 1) out vec4 weights1;
layout(location = 2) out vec4 soft0;
layout(location = 3) out vec4 soft1;

const float kStandIn = 1e-3;   // a camera beyond the chosen ones counts where those see nothing
const float kBlind = 1e-6;     // a camera that does not see the pixel counts where none does

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  weights0 = weights1 = soft0 = soft1 = vec4(0.0);
  uvec2 here = texelFetch(visibility, at, 0).xy;
  if (here.y == 0u) return;

  float radius = view.settings.y, nearest2[kMaxListed];
  for (int slot = 0; slot < kMaxListed; ++slot) nearest2[slot] = 1e9;
  int reach = int(ceil(radius)), height = int(view.window.w);
  for (int dy = -reach; dy <= reach; ++dy) {
    int y = at.y + dy;
    if (y < 0 || y >= height) continue;
    uvec2 row = texelFetch(row_distances, ivec2(at.x, y), 0).xy;
    if (row == uvec2(0xffffffffu)) continue;
    for (int slot = 0; slot < view.counts.x; ++slot) {
      uint dx = (slot < 4 ? row.x : row.y) >> (uint(slot & 3) * 8u) & 255u;
      if (dx != 255u) nearest2[slot] = min(nearest2[slot], float(dx * dx) + float(dy * dy));
    }
  }

  vec4 a0 = texelFetch(angular0_in, at, 0), a1 = texelFetch(angular1_in, at, 0);
  float weight[kMaxListed], soft[kMaxListed], sum = 0.0, best = -1.0;
  int best_slot = 0;
  for (int slot = 0; slot < kMaxListed; ++slot) {
    weight[slot] = soft[slot] = 0.0;
    if (slot >= view.counts.x) continue;
    float angular = slot < 4 ? a0[slot] : a1[slot - 4];
    bool visible = (here.x >> slot & 1u) != 0u;
    soft[slot] = !visible ? 0.0 : radius < 1.0 ? 1.0 : min(sqrt(nearest2[slot]) / radius, 1.0);
    vec2 fade = view.camera_fade[slot].xy;
    float reach_factor = angular > 0.0 ? 1.0 : 1e-3;
    weight[slot] = abs(angular) * (soft[slot] * (fade.x + kStandIn * fade.y) + kBlind * reach_factor);
    sum += weight[slot];
    float score = abs(angular) * (visible ? 1.0 : kBlind * reach_factor);
    if (score > best) {
      best = score;
      best_slot = slot;
    }
  }
  for (int slot = 0; slot < kMaxListed; ++slot) {
    float w = view.counts.z == 1 ? float(slot == best_slot) : weight[slot] / sum;
    if (slot < 4) {
      weights0[slot] = w;
      soft0[slot] = soft[slot];
    } else {
      weights1[slot - 4] = w;
      soft1[slot - 4] = soft[slot];
    }
  }
}
