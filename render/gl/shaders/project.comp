// The intermediate images I_i^v: each chosen photograph through the proxy; where its camera sees nothing, the blend
// of those that do. Alpha: 1 own colour, 0.5 filled, 0 no proxy.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform usampler2D visibility;
layout(location = 0) uniform int fill_hidden;  // 0: hidden places show what their photograph has there
layout(binding = 0) writeonly uniform image2DArray images;

const float kFaint = 1e-4;  // blend.comp has the same

vec3 projected(int slot, vec3 world, vec2 middle, vec4 here) {
  int index = listed(slot);
  vec2 pixel;
  photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel);
  return photo_color(index, pixel, footprint_if_deep(slot, middle, here));
}

bool reaches(int slot, vec3 world) {
  int index = listed(slot);
  vec2 pixel;
  return photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel);
}

bool own(int slot, uint seen, vec3 world) {
  return (seen >> slot & 1u) != 0u || (fill_hidden == 0 && reaches(slot, world));
}

void main() {
  ivec2 at = window_pixel();
  if (!in_window(at)) return;
  vec4 here = texelFetch(surface, at, 0);
  if (here.w >= kNothing) {
    for (int slot = 0; slot < view.counts.y; ++slot) imageStore(images, ivec3(at, slot), vec4(0.0));
    return;
  }
  vec2 middle = vec2(at) + 0.5;
  vec3 world = world_at(middle, here.w);
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  uint seen = texelFetch(visibility, at, 0).x, chosen = (1u << view.counts.y) - 1u;
  vec3 colors[kMaxListed], fill = vec3(0.0);
  float total = 0.0;
  bool whole = (seen & chosen) == chosen;  // nothing to fill
  for (int slot = 0; slot < view.counts.x; ++slot) {
    float w = slot < 4 ? w0[slot] : w1[slot - 4];
    bool counts = !whole && w >= kFaint;
    if (counts || (slot < view.counts.y && own(slot, seen, world))) colors[slot] = projected(slot, world, middle, here);
    if (!counts) continue;
    fill += w * colors[slot];
    total += w;
  }
  fill /= max(total, 1e-12);
  for (int slot = 0; slot < view.counts.y; ++slot)
    imageStore(images, ivec3(at, slot), own(slot, seen, world) ? vec4(colors[slot], 1.0) : vec4(fill, 0.5));
}
