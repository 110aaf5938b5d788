// How much each camera's idea of a position counts. Where the proxy is wrong by some depth along the viewing ray, camera
// j's image of the surface is displaced by its parallax u_j; the weights nearest to the angular ones (with sum 1) under
// which the displacements cancel: sum v_j u_j = 0. Those that would be negative are zero, the others share what is left.
// The twin of render/cpu/position_kernels.cpp.
const float kGrazing = 0.1;  // a camera that looks along the surface has no parallax beyond this cosine's
const float kSteady = 0.02;  // of the trace: keeps weights finite where cameras stand on one line
const float kTakenBack = 0.5;  // of a displacement, how much of what an error of depth does not explain
const float kFaintShare = 1.0 / 1024.0;  // shares below it do not count

// u_j of the camera in a slot, in units of the view's picture plane at z = 1; `at`, n in the view's coordinates.
vec2 parallax(int slot, vec3 ray, vec3 at, vec3 n, mat3 view_from_world) {
  vec3 center = view_from_world * (cameras[listed(slot)].center.xyz - view.view_center.xyz), d = at - center;
  return (center.xy - ray.xy * center.z) / min(dot(n, d), -kGrazing * length(d));
}

void parallaxes(vec2 pixel, vec4 surface, out vec2 u[kMaxListed]) {
  mat3 view_from_world = transpose(mat3(view.world_from_view));
  vec3 ray = view_ray(pixel), at = ray * surface.w, n = view_from_world * surface.xyz;
  for (int j = 0; j < view.counts.y; ++j) u[j] = parallax(j, ray, at, n, view_from_world);
}

void cancel_parallax(vec2 u[kMaxListed], inout float share[kMaxListed]) {
  vec2 sum = vec2(0.0);
  float xx = 0.0, xy = 0.0, yy = 0.0;
  int count = view.counts.y;
  for (int j = 0; j < count; ++j) {
    sum += share[j] * u[j];
    xx += share[j] * u[j].x * u[j].x;
    xy += share[j] * u[j].x * u[j].y;
    yy += share[j] * u[j].y * u[j].y;
  }
  float steady = kSteady * (xx + yy), a = xx + steady, b = yy + steady, determinant = a * b - xy * xy;
  if (determinant <= 0.0) return;
  vec2 q = vec2(b * sum.x - xy * sum.y, a * sum.y - xy * sum.x) / determinant;
  float total = 0.0;
  for (int j = 0; j < count; ++j) {
    share[j] *= max(0.0, 1.0 - dot(q, u[j]));
    total += share[j];
  }
  for (int j = 0; j < count; ++j) share[j] /= total;
}

// Fields say two numbers an image. A proxy that is wrong by some depth along the viewing ray explains them all by one:
// they read image i at depth (u_i - sum v_j u_j) from the pixel, v the position weights, and depth u_i is where it should
// be read. Half of what differs from that is taken back. `from`: where each image is read, px of the window.
void lean_on_depth(vec2 pixel, vec2 u[kMaxListed], float share[kMaxListed], float pull[kMaxListed],
                   inout vec2 from[kMaxListed]) {
  vec2 moved[kMaxListed], mean = vec2(0.0);
  int count = view.counts.y;
  for (int j = 0; j < count; ++j) {
    if (share[j] >= kFaintShare) mean += share[j] * u[j];
    float y = (from[j].y - pixel.y) / view.view_k.y;
    moved[j] = vec2((from[j].x - pixel.x - view.settings.x * y) / view.view_k.x, y);
  }
  float along = 0.0, all = 0.0;
  for (int j = 0; j < count; ++j) {
    vec2 q = u[j] - mean;
    float far = length(q);
    if (pull[j] < kFaintShare || far <= 0.0) continue;
    along += pull[j] * dot(q, moved[j]) / far;
    all += pull[j] * far;
  }
  float depth = all > 0.0 ? along / all : 0.0;
  for (int j = 0; j < count; ++j) {
    vec2 rest = kTakenBack * (moved[j] - depth * u[j]);
    from[j] -= vec2(rest.x * view.view_k.x + view.settings.x * rest.y, rest.y * view.view_k.y);
  }
}
