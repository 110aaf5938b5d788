// Mixes fields of the picture before into this one's, where that showed the same surface: fields are the surface's,
// whoever looks at it. The twin of render/cpu/field_memory.cpp.
layout(binding = 1) uniform sampler2D surface;
layout(binding = 2) uniform sampler2DArray found;          // this picture's fields
layout(binding = 3) uniform sampler2DArray kept;           // those of the picture before
layout(binding = 4) uniform sampler2D surface_before;
layout(binding = 0) writeonly uniform image2DArray mixed;
layout(location = 0) uniform ivec2 size;                   // of a field
layout(location = 1) uniform int fields;
layout(location = 2) uniform float share;                  // of what was kept, in what is written
// Mirrors MemoryBlock in render/gl/field_memory.cpp.
layout(std140, binding = 1) uniform MemoryBlock {
  mat4 view_from_world;
  vec4 k;            // fx, fy, cx, cy in its window, px
  vec4 window;       // width, height, skew
  ivec4 layers[14];  // of each field its layer in `kept`; -1: none
} before;

const float kMostStretch = 2.0;  // from one picture to the next; more is an edge

// Where the picture before shows what texel `at` of a field shows, px of its window.
bool place_of(ivec2 at, out vec2 place) {
  if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) return false;
  vec2 p = (vec2(at) + 0.5) * view.settings.w;
  if (!in_window(ivec2(p))) return false;
  float z = texelFetch(surface, ivec2(p), 0).w;
  if (z >= kNothing) return false;
  vec3 there = (before.view_from_world * vec4(world_at(p, z), 1.0)).xyz;
  if (there.z <= 0.0) return false;
  vec2 r = there.xy / there.z;
  place = vec2(r.x * before.k.x + before.window.z * r.y, r.y * before.k.y) + before.k.zw;
  if (any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, before.window.xy))) return false;
  float was = texelFetch(surface_before, ivec2(place), 0).w;
  return was < kNothing && abs(was - there.z) <= view.settings.z;
}

// How the picture before is stretched against this one along `step`: by the neighbours on the same surface.
bool stretch(ivec2 at, vec2 place, ivec2 step, out vec2 d) {
  for (int side = 1; side >= -1; side -= 2) {
    vec2 other;
    if (!place_of(at + side * step, other)) continue;
    d = float(side) * (other - place) / view.settings.w;
    float square = dot(d, d);
    if (square < kMostStretch * kMostStretch && square * kMostStretch * kMostStretch > 1.0) return true;
  }
  return false;
}

void main() {
  ivec2 at = window_pixel();
  if (any(greaterThanEqual(at, size))) return;
  vec2 place, along, down;
  bool known = before.window.x > 0.0 && place_of(at, place) && stretch(at, place, ivec2(1, 0), along) &&
               stretch(at, place, ivec2(0, 1), down);
  float determinant = known ? along.x * down.y - along.y * down.x : 0.0;
  known = known && determinant * kMostStretch * kMostStretch > 1.0;
  // The last texels that were written: beyond them is what an earlier, larger window left.
  vec2 last = floor((before.window.xy - 1.0) / view.settings.w);
  vec2 texel = clamp(place / view.settings.w, vec2(0.5), last + 0.5) / vec2(textureSize(kept, 0).xy);
  for (int field = 0; field < fields; ++field) {
    vec2 uv = texelFetch(found, ivec3(at, field), 0).xy;
    int layer = before.layers[field >> 2][field & 3];
    if (known && layer >= 0) {
      vec2 was = textureLod(kept, vec3(texel, layer), 0.0).xy;
      was = vec2(down.y * was.x - down.x * was.y, along.x * was.y - along.y * was.x) / determinant;
      uv = mix(uv, was, share);
    }
    imageStore(mixed, ivec3(at, field), vec4(uv, 0.0, 0.0));
  }
}
