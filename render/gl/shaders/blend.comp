// The weighted mean of the projected photographs (Eq. 9.1), or how far they disagree.
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;

const float kFaint = 1e-4;  // below half an 8-bit step even against the strongest contrast

vec3 projected(int slot, vec3 world, vec2 at, vec4 here) {
  int index = listed(slot);
  vec2 pixel;
  photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel);
  return photo_color(index, pixel, footprint_if_deep(slot, at, here));
}

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec2 middle = vec2(at) + 0.5;
  vec3 world = world_at(middle, here.w), sum = vec3(0.0);
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  float total = 0.0;
  for (int slot = 0; slot < view.counts.x; ++slot) {
    float w = slot < 4 ? w0[slot] : w1[slot - 4];
    if (w < kFaint) continue;
    sum += w * projected(slot, world, middle, here);
    total += w;
  }
  vec3 mean = sum / max(total, 1e-6);
  vec4 color = vec4(mean, 1.0);
  if (view.counts.w == kGhosting) {
    float apart = 0.0;
    for (int slot = 0; slot < view.counts.x; ++slot) {
      float w = slot < 4 ? w0[slot] : w1[slot - 4];
      if (w >= kFaint) apart += w / total * distance(projected(slot, world, middle, here), mean);
    }
    color.rgb = heat(3.0 * apart);
  }
  draw(color);
}
