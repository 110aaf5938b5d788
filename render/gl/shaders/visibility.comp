// Per pixel and listed camera: may it be used here (depth map, picture frame, matte), and its angular weight.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2DArray depth_maps;
layout(binding = 0) writeonly uniform uimage2D result_out;
layout(binding = 1) writeonly uniform image2D angular0_out;
layout(binding = 2) writeonly uniform image2D angular1_out;
layout(binding = 3) writeonly uniform image2D mattes_out;
layout(location = 0) uniform float unreached;  // how opaque is what no picture of the list reaches

uvec2 result = uvec2(0u);  // x: bit per listed camera, y: the proxy is here
// 1/angle, signed: negative where the camera's picture does not reach or shows no subject
vec4 angular0 = vec4(0.0), angular1 = vec4(0.0);
vec2 mattes = vec2(1.0);  // the mean and the largest of what they say where their cameras look

const float kSmallestAngle = 2e-5;  // rad (its inverse fits a half float); a camera nearer than this to the viewing ray has all the weight
const float kGrazing = 0.02;        // cosine below which a camera sees nothing of a surface
const float kOpaque = 0.5;
const float kStandIn = 1e-3;  // mattes of cameras beyond the chosen ones count so much

// Fraction of the four depth map texels around p that the surface's own plane explains.
float seen(int index, vec3 p, vec3 n, float tolerance) {
  float facing = -dot(n, p) * inversesqrt(dot(p, p));
  if (facing < kGrazing) return 0.0;
  vec4 window = cameras[index].depth;
  vec2 at = window.xy * p.xy / p.z + window.zw - 0.5;
  ivec2 size = textureSize(depth_maps, 0).xy, low = ivec2(floor(at));
  if (any(lessThan(low, ivec2(0))) || any(greaterThan(low, size - 2))) return 1.0;  // outside the proxy's bounds
  vec2 f = at - vec2(low);
  int layer = int(cameras[index].image.z);
  float plane = dot(n, p), sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 offset = ivec2(i & 1, i >> 1);
    vec2 texel = (vec2(low + offset) + 0.5 - window.zw) / window.xy;
    // The surface is flat only near p: a grazing plane must not explain any depth there is.
    float expected = clamp(plane / min(dot(n, vec3(texel, 1.0)), -1e-6), p.z - 2.0 * tolerance, p.z + 2.0 * tolerance);
    float weight = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
    if (texelFetch(depth_maps, ivec3(low + offset, layer), 0).x >= expected - tolerance) sum += weight;
  }
  return sum;
}

void look(ivec2 at) {
  vec4 s = texelFetch(surface, at, 0);
  if (s.w >= kNothing) return;
  result.y = 1u;
  vec3 world = world_at(vec2(at) + 0.5, s.w);
  vec3 to_view = normalize(view.view_center.xyz - world);
  float sum = 0.0, total = 0.0, most = 0.0, behind = unreached;
  for (int slot = 0; slot < view.counts.x; ++slot) {
    int index = listed(slot);
    vec3 p = (cameras[index].cam_from_world * vec4(world, 1.0)).xyz;
    vec3 to_camera = normalize(cameras[index].center.xyz - world);
    float chord = distance(to_view, to_camera);  // precise near zero, where acos is not
    float angular = 1.0 / max(2.0 * asin(min(0.5 * chord, 1.0)), kSmallestAngle);
    vec2 pixel;
    if (photo_pixel(index, p, pixel)) {
      vec3 n = mat3(cameras[index].cam_from_world) * s.xyz;
      float matte = photo(index, pixel).a;
      behind = max(behind, matte);
      if (seen(index, p, n, view.settings.z) >= 0.5) {
        float counts = angular * (view.camera_fade[slot].x + kStandIn * view.camera_fade[slot].y);
        if (matte >= kOpaque) result.x |= 1u << slot;
        sum += counts * matte;
        total += counts;
        most = max(most, matte);
      }
      if (matte < kOpaque) angular = -angular;
    } else {
      angular = -angular;
    }
    if (slot < 4)
      angular0[slot] = angular;
    else
      angular1[slot - 4] = angular;
  }
  if (total > 0.0)
    mattes = vec2(sum / total, most);
  else
    mattes.y = behind;
}

void main() {
  ivec2 at = window_pixel();
  if (!in_window(at)) return;
  look(at);
  imageStore(result_out, at, uvec4(result, 0u, 0u));
  imageStore(angular0_out, at, angular0);
  imageStore(angular1_out, at, angular1);
  imageStore(mattes_out, at, vec4(mattes, 0.0, 0.0));
}
