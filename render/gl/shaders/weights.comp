// Second pass of the distance filter, then the final weights: angular weight x soft visibility, normalised.
layout(binding = 1) uniform usampler2D visibility;
layout(binding = 2) uniform usampler2D row_distances;
layout(binding = 3) uniform sampler2D angular0_in;
layout(binding = 4) uniform sampler2D angular1_in;
layout(binding = 0) writeonly uniform image2D weights0_out;
layout(binding = 1) writeonly uniform image2D weights1_out;
layout(binding = 2) writeonly uniform image2D soft0_out;
layout(binding = 3) writeonly uniform image2D soft1_out;

vec4 weights0 = vec4(0.0), weights1 = vec4(0.0), soft0 = vec4(0.0), soft1 = vec4(0.0);

// Four kinds of cameras, each let in by degrees as far as those before it hold too small a share of the weight that
// they would have without visibility: the chosen ones that see the pixel, whoever of the list sees it, whoever has
// it in the picture, all. So a camera that comes or goes with a faint weight never decides alone, in time or beside
// an edge of visibility. One that does not have a point in its picture counts there as much as the next one at most,
// however near the view is to it: its border does not keep out who has it. The twin of render/cpu/weight_kernels.cpp.
const float kEnough = 0.3, kEnoughOfList = 0.01;  // shares that keep the next kind out
const float kBlind = 1e-6, kReachesNot = 1e-3;    // one camera a pixel: without sight of it, without it in the picture
const float kLeast = 1e-30;

void weigh(ivec2 at) {
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
  float angular[kMaxListed], soft[kMaxListed], best = -1.0;
  float all_chosen = kLeast, chosen = 0.0, all_listed = kLeast, in_list = 0.0, in_picture = 0.0;
  float strongest = 0.0, second = 0.0, beside = 0.0;  // of the list; of those that do not have it
  int best_slot = 0;
  for (int slot = 0; slot < kMaxListed; ++slot) {
    angular[slot] = soft[slot] = 0.0;
    if (slot >= view.counts.x) continue;
    angular[slot] = slot < 4 ? a0[slot] : a1[slot - 4];
    bool visible = (here.x >> slot & 1u) != 0u, reaches = angular[slot] > 0.0;
    soft[slot] = !visible ? 0.0 : radius < 1.0 ? 1.0 : min(sqrt(nearest2[slot]) / radius, 1.0);
    vec2 as = abs(angular[slot]) * view.camera_fade[slot].xy;  // one of the chosen, one of the list
    all_chosen += as.x;
    chosen += as.x * soft[slot];
    all_listed += as.y;
    in_list += as.y * soft[slot];
    second = max(second, min(strongest, as.y));
    strongest = max(strongest, as.y);
    if (reaches)
      in_picture += as.y;
    else
      beside = max(beside, as.y);
    float score = abs(angular[slot]) * (visible ? 1.0 : reaches ? kBlind : kBlind * kReachesNot);
    if (score > best) {
      best = score;
      best_slot = slot;
    }
  }
  float of_chosen = 1.0 / max(chosen, kEnough * all_chosen), rest = 1.0 - chosen * of_chosen;
  float enough_listed = kEnoughOfList * (all_listed - max(0.0, beside - second));
  float of_list = rest / max(in_list, enough_listed);
  rest -= in_list * of_list;
  float of_picture = rest / max(in_picture, enough_listed);
  float of_any = (rest - in_picture * of_picture) / all_listed;
  for (int slot = 0; slot < kMaxListed; ++slot) {
    vec2 fade = slot < view.counts.x ? view.camera_fade[slot].xy : vec2(0.0);
    float seen = soft[slot] * (fade.x * of_chosen + fade.y * of_list);
    float unseen = fade.y * (of_any + (angular[slot] > 0.0 ? of_picture : 0.0));
    float w = view.counts.z == 1 ? float(slot == best_slot) : abs(angular[slot]) * (seen + unseen);
    if (slot < 4) {
      weights0[slot] = w;
      soft0[slot] = soft[slot];
    } else {
      weights1[slot - 4] = w;
      soft1[slot - 4] = soft[slot];
    }
  }
}

void main() {
  ivec2 at = window_pixel();
  if (!in_window(at)) return;
  weigh(at);
  imageStore(weights0_out, at, weights0);
  imageStore(weights1_out, at, weights1);
  imageStore(soft0_out, at, soft0);
  imageStore(soft1_out, at, soft1);
}
