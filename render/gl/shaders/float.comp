// Warps the intermediate images onto one another and blends them (Eq. 11.2, 11.3).
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform sampler2DArray images;  // alpha: see project.comp
layout(binding = 5) uniform sampler2DArray flows;   // layer of I_i -> I_j: i (n - 1) + j, one less beyond i
layout(binding = 6) uniform sampler2D angular0;
layout(binding = 7) uniform sampler2D angular1;
layout(binding = 8) uniform sampler2D soft0;
layout(binding = 9) uniform sampler2D soft1;
layout(binding = 10) uniform sampler2DArray confidence;  // as flows; only where it is shown
layout(binding = 11) uniform sampler2DArray displacement;  // one layer; only by depth
layout(location = 1) uniform int positions;  // 0: parallax cancels, 1: the angular mean
layout(location = 2) uniform ivec2 shown;    // slots of the camera to show and of the other one; -1: none
layout(location = 3) uniform bool any;       // nobody said which camera to show
layout(location = 4) uniform bool by_depth;  // images share a displacement; else there are fields

const int kInversions = 4;
const float kLeastFade = 1e-4;
const float kEnough = 0.3;  // weights.comp has the same

float pull[kMaxListed];   // how much each camera counts: angular weights, visible or not
float place[kMaxListed];  // how much its idea of a position counts

int flow_layer(int i, int j) { return i * (view.counts.y - 1) + (j < i ? j : j - 1); }

// W_i at p: where the combined warp moves what I_i shows at p.
vec2 combined_warp(int i, vec2 p) {
  vec2 size = view.settings.w * vec2(textureSize(flows, 0).xy), sum = vec2(0.0);
  int n = view.counts.y;
  for (int j = 0; j < n; ++j) {
    if (j == i || place[j] < kFaintShare) continue;
    sum += place[j] * textureLod(flows, vec3(p / size, flow_layer(i, j)), 0.0).xy;
  }
  return view.settings.w * sum;
}

// I_i at p: straight from the photograph where I_i has its own colour on a connected surface (one resampling instead
// of two), as large as the pixel sees it, else from the intermediate image. False: nothing there.
bool image_at(int i, vec2 p, float area, out vec3 rgb) {
  ivec2 low = ivec2(floor(p - 0.5)), last = ivec2(view.window.zw) - 1;
  vec2 f = p - 0.5 - vec2(low);
  vec4 sum = vec4(0.0);
  float inverse_z = 0.0, least = kNothing, most = 0.0;
  bool own = true;
  for (int k = 0; k < 4; ++k) {
    ivec2 o = ivec2(k & 1, k >> 1), at = clamp(low + o, ivec2(0), last);
    float w = (o.x == 1 ? f.x : 1.0 - f.x) * (o.y == 1 ? f.y : 1.0 - f.y);
    vec4 c = texelFetch(images, ivec3(at, i), 0);
    float z = texelFetch(surface, at, 0).w;
    sum += w * vec4(c.rgb, c.a > 0.0 ? 1.0 : 0.0);  // rgb is zero off the proxy
    own = own && c.a > 0.75;
    inverse_z += w / z;
    least = min(least, z);
    most = max(most, z);
  }
  if (own && most - least < view.settings.z) {
    int index = listed(i);
    vec2 pixel;
    vec3 world = world_at(p, 1.0 / inverse_z);
    if (photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel)) {
      rgb = photo_color(index, pixel, area);
      return true;
    }
  }
  rgb = sum.rgb / max(sum.a, 1e-3);
  return sum.a >= 0.5;
}

// Of a pixel in the field from image i to image j.
ivec3 flow_place(ivec2 at, int i, int j) {
  return ivec3(min(at / int(view.settings.w), textureSize(flows, 0).xy - 1), flow_layer(i, j));
}
vec2 field_at(ivec2 at, int i, int j) { return view.settings.w * texelFetch(flows, flow_place(at, i, j), 0).xy; }
float confidence_at(ivec2 at, int i, int j) {
  ivec3 place = by_depth ? ivec3(at / int(view.settings.w), 0) : flow_place(at, i, j);
  return texelFetch(confidence, place, 0).x;
}

vec2 in_pixels(vec2 u) { return vec2(u.x * view.view_k.x + view.settings.x * u.y, u.y * view.view_k.y); }

// Where images are read that stand beside their places by one displacement along their parallaxes, a pair by 1 px in the
// mean. The twin of cpu/position_kernels.cpp.
void place_at_depth(vec2 x, vec2 u[kMaxListed], out vec2 from[kMaxListed]) {
  int n = view.counts.y;
  float all = 0.0, pairs = 0.0, apart = 0.0;
  for (int i = 0; i < n; ++i) all += view.camera_fade[i].x;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      float both = all > 0.0 ? view.camera_fade[i].x * view.camera_fade[j].x : 1.0;
      pairs += both;
      apart += both * length(in_pixels(u[i] - u[j]));
    }
  float s = view.settings.w;
  vec2 size = s * vec2(textureSize(displacement, 0).xy);
  float moved = apart > 0.0 ? s * textureLod(displacement, vec3(x / size, 0.0), 0.0).x * (pairs / apart) : 0.0;
  for (int i = 0; i < n; ++i) from[i] = x + moved * in_pixels(u[i]);
}

// What plain blending of `visible` photographs does to what is here, by how far the fields find it apart.
vec3 measured(ivec2 at, vec4 here, float visible[kMaxListed], vec2 from[kMaxListed]) {
  int worst = kSharp;
  float spacing[kMaxListed];
  for (int i = 0; i < view.counts.y; ++i) {
    spacing[i] = pixel_spacing(i, vec2(at) + 0.5, here);
    if (visible[i] < kFaintShare) continue;
    worst = max(worst, blend_class(0.0, spacing[i], spacing[i]));
    for (int j = 0; j < i; ++j)
      if (visible[j] >= kFaintShare)
        worst = max(worst, blend_class(by_depth ? distance(from[i], from[j])
                                                : max(length(field_at(at, i, j)), length(field_at(at, j, i))),
                                       spacing[i], spacing[j]));
  }
  return class_color(worst);
}

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  vec4 a0 = texelFetch(angular0, at, 0), a1 = texelFetch(angular1, at, 0);
  int n = view.counts.y;
  float pull_total = 0.0;
  for (int i = 0; i < n; ++i) {
    float fade = view.camera_fade[i].x;
    pull[i] = fade < kLeastFade ? 0.0 : abs(i < 4 ? a0[i] : a1[i - 4]) * fade;
    pull_total += pull[i];
  }
  for (int i = 0; i < n; ++i) pull[i] = pull_total > 0.0 ? pull[i] / pull_total : 1.0 / float(n);

  place = pull;
  vec2 x = vec2(at) + 0.5, u[kMaxListed];
  if (positions == 0) {
    parallaxes(x, here, u);
    cancel_parallax(u, place);
  }

  vec2 strongest_warp = vec2(0.0), from[kMaxListed];
  if (by_depth) place_at_depth(x, u, from);
  for (int i = 0; i < n && !by_depth; ++i) {
    from[i] = x;
    if (pull[i] < kFaintShare) continue;
    // I_i's point p lands at p + W_i(p): find the one that lands here.
    for (int k = 0; k < kInversions; ++k) from[i] = x - combined_warp(i, from[i]);
  }
  if (positions == 0 && !by_depth && n > 1) lean_on_depth(x, u, place, pull, from);
  vec3 sum = vec3(0.0), colors[kMaxListed];
  float used[kMaxListed], hidden[kMaxListed], total = 0.0, all_hidden = 0.0, strongest = -1.0;
  for (int i = 0; i < n; ++i) {
    used[i] = hidden[i] = 0.0;
    if (pull[i] < kFaintShare) continue;
    vec2 p = from[i];
    float area = footprint_if_deep(i, x, here);
    if (!image_at(i, p, area, colors[i])) {
      p = x;
      image_at(i, p, area, colors[i]);
    }
    // What matters is whether camera i sees the point whose colour arrives here, not the point that is here.
    vec2 there = p / vec2(textureSize(soft0, 0));
    float seen = i < 4 ? textureLod(soft0, there, 0.0)[i] : textureLod(soft1, there, 0.0)[i - 4];
    used[i] = pull[i] * seen;
    hidden[i] = pull[i] - used[i];
    total += used[i];
    all_hidden += hidden[i];
    if (any ? pull[i] > strongest : i == shown.x) {
      strongest = pull[i];
      strongest_warp = x - from[i];
    }
  }
  // Where little of what arrives is seen, the images of those that do not see it count, which hold the blend of all
  // that do.
  float filled = total < kEnough && all_hidden > 0.0 ? (kEnough - total) / all_hidden : 0.0;
  total = 0.0;
  for (int i = 0; i < n; ++i) {
    used[i] += filled * hidden[i];
    if (used[i] > 0.0) sum += used[i] * colors[i];
    total += used[i];
  }
  vec3 mean = sum / total;
  vec4 color = vec4(mean, 1.0);
  int wanted = view.counts.w;
  if (wanted == kGhosting) {
    float apart = 0.0;
    for (int i = 0; i < n; ++i)
      if (used[i] > 0.0) apart += used[i] / total * distance(colors[i], mean);
    color.rgb = heat(3.0 * apart);
  } else if (wanted == kFlow) {
    color.rgb = any || shown.x >= 0 ? flow_color(strongest_warp) : vec3(0.0);
  } else if (wanted == kWarped) {
    color.rgb = shown.x >= 0 && used[shown.x] >= kFaintShare * total ? colors[shown.x] : vec3(0.0);
  } else if (wanted == kPositionWeights || wanted == kColorWeights) {
    float all = 0.0;
    color.rgb = vec3(0.0);
    for (int i = 0; i < n; ++i) {
      float share = wanted == kColorWeights ? used[i] : place[i] < kFaintShare ? 0.0 : place[i];
      color.rgb += share * camera_color(listed(i));
      all += share;
    }
    color.rgb /= max(all, 1e-12);
  } else if (wanted == kField || wanted == kConfidence) {
    color.rgb = shown.x < 0 || shown.y < 0 ? vec3(0.0)
                : wanted == kField ? flow_color(by_depth ? from[shown.y] - from[shown.x] : field_at(at, shown.x, shown.y))
                                           : vec3(confidence_at(at, shown.x, shown.y));
  } else if (wanted == kMeasured) {
    float visible[kMaxListed];
    for (int i = 0; i < n; ++i) visible[i] = i < 4 ? w0[i] : w1[i - 4];
    color.rgb = measured(at, here, visible, from);
  }
  draw(color);
}
