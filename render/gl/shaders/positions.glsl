// How much each camera's idea of a position counts. Where the proxy is wrong by some depth along the viewing ray, camera
// j's image of the surface is displaced by its parallax u_j; the weights nearest to the angular ones (with sum 1) under
// which the displacements cancel: sum v_j u_j = 0. Those that would be negative are zero, the others share what is left.
// The twin of render/cpu/position_kernels.cpp.
const float kGrazing = 0.1;  // a camera that looks along the surface has no parallax beyond this cosine's
const float kSteady = 0.02;  // of the trace: keeps weights finite where cameras stand on one line

// u_j of the camera in a slot, in units of the view's picture plane at z = 1; `at`, n in the view's coordinates.
vec2 parallax(int slot, vec3 ray, vec3 at, vec3 n, mat3 view_from_world) {
  vec3 center = view_from_world * (cameras[listed(slot)].center.xyz - view.view_center.xyz), d = at - center;
  return (center.xy - ray.xy * center.z) / min(dot(n, d), -kGrazing * length(d));
}

void cancel_parallax(vec2 pixel, vec4 surface, inout float share[kMaxListed]) {
  mat3 view_from_world = transpose(mat3(view.world_from_view));
  vec3 ray = view_ray(pixel), at = ray * surface.w, n = view_from_world * surface.xyz;
  vec2 u[kMaxListed], sum = vec2(0.0);
  float xx = 0.0, xy = 0.0, yy = 0.0;
  int count = view.counts.y;
  for (int j = 0; j < count; ++j) {
    u[j] = parallax(j, ray, at, n, view_from_world);
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
