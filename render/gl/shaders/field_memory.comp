// Mixes fields of the picture before into this one's, where that showed the same surface: fields are the surface's,
// whoever looks at it. The twin of render/cpu/field_memory.cpp.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2DArray found;          // this picture's fields
layout(binding = 3) uniform sampler2DArray kept;           // those of the picture before
layout(binding = 4) uniform sampler2D surface_before;
layout(binding = 0) writeonly uniform image2DArray mixed;
layout(location = 0) uniform ivec2 size;                   // of a field
layout(location = 1) uniform int fields;
// Mirrors MemoryBlock in render/gl/field_memory.cpp.
layout(std140, binding = 1) uniform MemoryBlock {
  mat4 view_from_world;
  mat4 now_from_then;  // from that view's coordinates to this one's
  vec4 k;              // fx, fy, cx, cy in its window, px
  vec4 window;         // width, height, skew
  ivec4 layers[14];    // of each field its layer in `kept`; -1: none
  vec4 shares[14];     // of what is kept, in what is written
} before;

// A point of the picture before, z of its surface there. False: nothing there.
bool surface_then(vec2 place, out float z) {
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, before.window.xy))) return false;
  z = texelFetch(surface_before, ivec2(place), 0).w;
  return z < kNothing;
}

// Where this picture shows a point of the one before, px of the window. False: behind its eye.
bool here(vec2 place, float z, out vec2 seen) {
  vec2 p = place - before.k.zw;
  float y = p.y / before.k.y;
  vec4 at = before.now_from_then * vec4(z * (p.x - before.window.z * y) / before.k.x, z * y, z, 1.0);
  vec2 r = at.xy / at.z;
  seen = vec2(r.x * view.view_k.x + view.settings.x * r.y, r.y * view.view_k.y) + view.view_k.zw - view.window.xy;
  return at.z > 0.0;
}

// Where the picture before shows what texel `at` of a field shows, if it does.
bool place_of(ivec2 at, out vec2 place, out float was) {
  vec2 p = (vec2(at) + 0.5) * view.settings.w;
  if (!in_window(ivec2(p))) return false;
  float z = texelFetch(surface, ivec2(p), 0).w;
  if (z >= kNothing) return false;
  vec3 there = (before.view_from_world * vec4(world_at(p, z), 1.0)).xyz;
  if (there.z <= 0.0) return false;
  vec2 r = there.xy / there.z;
  place = vec2(r.x * before.k.x + before.window.z * r.y, r.y * before.k.y) + before.k.zw;
  return surface_then(place, was) && abs(was - there.z) <= view.settings.z;
}

void main() {
  ivec2 at = window_pixel();
  if (any(greaterThanEqual(at, size))) return;
  vec2 place, home;
  float was;
  bool known = before.window.x > 0.0 && place_of(at, place, was) && here(place, was, home);
  // The last texels that were written: beyond them is what an earlier, larger window left.
  vec2 last = floor((before.window.xy - 1.0) / view.settings.w);
  vec2 texel = clamp(place / view.settings.w, vec2(0.5), last + 0.5) / vec2(textureSize(kept, 0).xy);
  for (int field = 0; field < fields; ++field) {
    vec2 uv = texelFetch(found, ivec3(at, field), 0).xy;
    int layer = before.layers[field >> 2][field & 3];
    if (known && layer >= 0) {
      // Both ends lie on the surface; an end beyond its edge is as far as its beginning.
      vec2 end = place + view.settings.w * textureLod(kept, vec3(texel, layer), 0.0).xy, seen;
      float z;
      if (!surface_then(end, z) || abs(z - was) > view.settings.z) z = was;
      if (here(end, z, seen)) uv = mix(uv, (seen - home) / view.settings.w, before.shares[field >> 2][field & 3]);
    }
    imageStore(mixed, ivec3(at, field), vec4(uv, 0.0, 0.0));
  }
}
