// How much each camera's idea of a position counts. Where the proxy is wrong by some depth along the viewing ray, camera
// j's image of the surface is displaced by its parallax u_j; the weights nearest to the angular ones, with sum 1 and none
// negative, under which the displacements cancel: sum v_j u_j = 0. The twin of render/cpu/position_kernels.cpp.
const float kGrazing = 0.1;  // a camera that looks along the surface has no parallax beyond this cosine's
const float kSteady = 0.02;  // of the trace: keeps weights finite where cameras stand on one line
const int kRounds = 4;       // after which it is settled which cameras count

void cancel_parallax(vec2 pixel, vec4 surface, inout float share[kMaxListed]) {
  mat3 view_from_world = transpose(mat3(view.world_from_view));
  vec3 ray = view_ray(pixel), at = ray * surface.w, n = view_from_world * surface.xyz;
  vec2 u[kMaxListed], pull = vec2(0.0);
  int count = view.counts.y;
  for (int j = 0; j < count; ++j) {
    vec3 center = view_from_world * (cameras[listed(j)].center.xyz - view.view_center.xyz), d = at - center;
    u[j] = (center.xy - ray.xy * center.z) / min(dot(n, d), -kGrazing * length(d));
  }
  // v_j = w_j max(0, scale - pull u_j), which follows from the cameras that count.
  float scale = 1.0, steady = 0.0, sum = 0.0;
  for (int turn = 0; turn < kRounds; ++turn) {
    float total = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    vec2 s = vec2(0.0);
    for (int j = 0; j < count; ++j) {
      float w = scale - dot(pull, u[j]) > 0.0 ? share[j] : 0.0;
      total += w;
      s += w * u[j];
      xx += w * u[j].x * u[j].x;
      xy += w * u[j].x * u[j].y;
      yy += w * u[j].y * u[j].y;
    }
    if (turn == 0) steady = kSteady * (xx + yy);
    float a = xx + steady, b = yy + steady, determinant = a * b - xy * xy;
    vec2 q = determinant > 0.0 ? vec2(b * s.x - xy * s.y, a * s.y - xy * s.x) / determinant : vec2(0.0);
    float left = total - dot(q, s);
    scale = left > 0.0 ? 1.0 / left : 1.0;
    pull = scale * q;
  }
  for (int j = 0; j < count; ++j) {
    share[j] *= max(0.0, scale - dot(pull, u[j]));
    sum += share[j];
  }
  for (int j = 0; j < count; ++j) share[j] /= sum;
}
