// Warps the intermediate images onto one another and blends them (Eq. 11.2, 11.3).
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform sampler2DArray images;  // rgb zero and alpha 0 off the proxy
layout(binding = 5) uniform sampler2DArray flows;   // layer of I_i -> I_j: i (n - 1) + j, one less beyond i
layout(location = 0) uniform ivec2 window_in_target;
layout(location = 0) out vec4 color;

const int kInversions = 4;
const float kFaint = 1.0 / 1024.0;

float weight[kMaxListed];

// W_i at p: where the combined warp moves what I_i shows at p.
vec2 combined_warp(int i, vec2 p) {
  vec2 size = vec2(textureSize(flows, 0).xy), sum = vec2(0.0);
  int n = view.counts.y;
  for (int j = 0; j < n; ++j) {
    if (j == i || weight[j] < kFaint) continue;
    int layer = i * (n - 1) + (j < i ? j : j - 1);
    sum += weight[j] * textureLod(flows, vec3(p / size, layer), 0.0).xy;
  }
  return sum;
}

vec4 image_at(int i, vec2 p) { return textureLod(images, vec3(p / vec2(textureSize(images, 0).xy), i), 0.0); }

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - window_in_target;
  if (texelFetch(surface, at, 0).w >= kNothing) discard;
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  int n = view.counts.y, strongest = 0;
  float total = 0.0;
  for (int i = 0; i < n; ++i) {
    weight[i] = i < 4 ? w0[i] : w1[i - 4];
    total += weight[i];
  }
  for (int i = 0; i < n; ++i) {
    // Where only stand-ins see the proxy all images hold the same filled colour.
    weight[i] = total > 1e-3 ? weight[i] / total : 1.0 / float(n);
    if (weight[i] > weight[strongest]) strongest = i;
  }

  vec2 x = vec2(at) + 0.5, shown_warp = vec2(0.0);
  vec3 sum = vec3(0.0), colors[kMaxListed];
  float used = 0.0;
  for (int i = 0; i < n; ++i) {
    if (weight[i] < kFaint) continue;
    // I_i's point p lands at p + W_i(p): find the one that lands here.
    vec2 p = x, warp = vec2(0.0);
    for (int k = 0; k < kInversions; ++k) {
      warp = combined_warp(i, p);
      p = x - warp;
    }
    vec4 c = image_at(i, p);
    if (c.a < 0.5) c = image_at(i, x);
    colors[i] = c.rgb / max(c.a, 1e-3);
    sum += weight[i] * colors[i];
    used += weight[i];
    if (i == strongest) shown_warp = warp;
  }
  vec3 mean = sum / max(used, 1e-6);
  color = vec4(mean, 1.0);
  if (view.counts.w == kFlow) {
    float length_px = length(shown_warp);
    color.rgb = mix(vec3(1.0), hue(atan(shown_warp.y, shown_warp.x) / 6.2831853), min(length_px / 8.0, 1.0));
  } else if (view.counts.w == kGhosting) {
    float apart = 0.0;
    for (int i = 0; i < n; ++i)
      if (weight[i] >= kFaint) apart += weight[i] / used * distance(colors[i], mean);
    color.rgb = heat(3.0 * apart);
  }
}
