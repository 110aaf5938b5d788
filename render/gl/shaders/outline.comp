// The picture with its opacity: how much of a pixel the proxy covers, times what the mattes say near the outline. The
// twin of render/cpu/outline.cpp.
layout(binding = 2) uniform sampler2DMS samples;  // 1 where the proxy covers one of the pixel's four samples
layout(binding = 3) uniform sampler2D mattes;   // the mean and the largest of what they say; see visibility.comp
layout(binding = 4) uniform sampler2D picture;

const int kGroup = 8, kAround = kGroup + 2;  // px: picture.glsl's; with the pixels beside it
const float kNear = 0.5;  // of soft visibility's radius: how far from the outline mattes count
const int kOpacity = 7;  // RenderOutput::Opacity

// What no picture shows has no part in it.
bool shown(ivec2 at) {
  ivec2 there = at + window_in_picture;
  return in_window(at) && all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, textureSize(picture, 0)));
}
bool outside(ivec2 at) { return texelFetch(surface, at, 0).w >= kNothing; }

// Opacity of a pixel whose centre the proxy covers, but for the coverage.
float solid(ivec2 at) {
  vec2 matte = texelFetch(mattes, at, 0).xy;
  float opacity = 1.0, radius = kNear * view.settings.y;
  int reach = int(ceil(radius));
  if (matte.x < 1.0 && radius > 1.0) {
    float nearest2 = 1e9;
    for (int dy = -reach; dy <= reach; ++dy) {
      if (float(dy * dy) >= nearest2) continue;
      for (int dx = -reach; dx <= reach; ++dx) {
        float distance2 = float(dx * dx + dy * dy);
        ivec2 there = at + ivec2(dx, dy);
        if (distance2 < nearest2 && shown(there) && outside(there)) nearest2 = distance2;
      }
    }
    opacity -= (1.0 - matte.x) * clamp((radius - sqrt(nearest2)) / (radius - 1.0), 0.0, 1.0);
  }
  return min(opacity, 2.0 * matte.y);
}

// solid() of the group's pixels and those beside them, 0 where nothing shows: each is asked for up to nine times.
shared float opacities[kAround * kAround];

ivec2 beside_group() { return ivec2(gl_WorkGroupID.xy) * kGroup - window_in_picture - 1; }
float opacity_at(ivec2 at) {
  ivec2 local = at - beside_group();
  return opacities[local.y * kAround + local.x];
}

// The picture's pixel at a place of the window, with its opacity. False: nothing shows there.
bool softened(ivec2 at, out vec4 color) {
  bool center = !outside(at);
  float covered = 0.0;
  for (int k = 0; k < 4; ++k) covered += 0.25 * texelFetch(samples, at, k).x;
  if (!center && covered == 0.0) return false;
  bool rim = false;
  if (!center || covered < 1.0)
    for (int k = 0; k < 9; ++k) {
      ivec2 next = at + ivec2(k % 3, k / 3) - 1;
      rim = rim || (shown(next) && outside(next) == center);
    }
  if (center) {
    color = vec4(texelFetch(picture, at + window_in_picture, 0).rgb, opacity_at(at));
    if (rim) color.a *= max(covered, 0.25);
    return true;
  }
  if (!rim) return false;
  vec3 sum = vec3(0.0);
  float weight = 0.0, count = 0.0;
  for (int k = 0; k < 9; ++k) {
    ivec2 next = at + ivec2(k % 3, k / 3) - 1;
    if (!shown(next) || outside(next)) continue;
    sum += texelFetch(picture, next + window_in_picture, 0).rgb;
    weight += opacity_at(next);
    count += 1.0;
  }
  color = vec4(sum / max(count, 1.0), weight / max(count, 1.0) * covered);
  return weight > 0.0;
}

void main() {
  for (int i = int(gl_LocalInvocationIndex); i < kAround * kAround; i += kGroup * kGroup) {
    ivec2 there = beside_group() + ivec2(i % kAround, i / kAround);
    opacities[i] = shown(there) && !outside(there) ? solid(there) : 0.0;
  }
  synchronize();
  ivec2 at = pixel_here();
  vec4 color;
  bool there = in_window(at) && softened(at, color);
  bool opacity = view.counts.w == kOpacity;
  if (!there || (opacity && color.a < 0.5 / 255.0))
    draw_background();
  else
    draw(opacity ? vec4(vec3(color.a), 1.0) : color);
}
