// The intermediate images I_i^v: each chosen photograph through the proxy; where its camera sees nothing, the colour
// of the strongest camera that does. Alpha: 1 own colour, 0.5 filled, 0 no
// proxy.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2D weights0;
layout(binding = 3) uniform sampler2D weights1;
layout(binding = 4) uniform usampler2D visibility;
layout(location = 0) uniform int fill_hidden;  // 0: hidden places show what their photograph has there
layout(location = 0) out vec4 images[kMaxListed];

vec3 projected(int slot, vec3 world, vec4 here) {
  int index = listed(slot);
  vec2 pixel;
  photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel);
  return photo_color(index, pixel, footprint_if_deep(slot, gl_FragCoord.xy, here));
}

bool reaches(int slot, vec3 world) {
  int index = listed(slot);
  vec2 pixel;
  return photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, pixel);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  for (int slot = 0; slot < kMaxListed; ++slot) images[slot] = vec4(0.0);
  vec4 here = texelFetch(surface, at, 0);
  if (here.w >= kNothing) return;
  vec3 world = world_at(gl_FragCoord.xy, here.w);
  vec4 w0 = texelFetch(weights0, at, 0), w1 = texelFetch(weights1, at, 0);
  int best = 0;
  float best_weight = -1.0;
  for (int slot = 0; slot < view.counts.x; ++slot) {
    float w = slot < 4 ? w0[slot] : w1[slot - 4];
    if (w > best_weight) {
      best_weight = w;
      best = slot;
    }
  }
  uint seen = texelFetch(visibility, at, 0).x | 1u << best;
  vec3 fill = projected(best, world, here);
  for (int slot = 0; slot < kMaxListed; ++slot) {
    if (slot >= view.counts.y) break;
    bool own = (seen >> slot & 1u) != 0u || (fill_hidden == 0 && reaches(slot, world));
    images[slot] = vec4(own ? slot == best ? fill : projected(slot, world, here) : fill, own ? 1.0 : 0.5);
  }
}
