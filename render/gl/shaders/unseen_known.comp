// The picture's colours, known where somebody sees what they show, for fill_pull.comp: red and green in one layer, blue
// in the other; and how many pixels somebody sees. The twin of render/cpu/unseen.cpp.
layout(binding = 1) uniform usampler2D visibility;  // visibility.comp; none where the proxy is not
layout(binding = 2) uniform sampler2D picture;
layout(binding = 0) writeonly uniform image2DArray known_out;
layout(location = 0) uniform ivec2 window_in_picture;
layout(location = 1) uniform ivec2 size;  // of the window without its margin
layout(location = 2) uniform int margin;

layout(std430, binding = 3) buffer Seen { uint shown, seen; };  // render/seen_pixels.h
shared uint shown_here, seen_here;

void main() {
  if (gl_LocalInvocationIndex == 0u) shown_here = seen_here = 0u;
  synchronize();
  ivec2 here = window_pixel(), at = here + margin, there = at + window_in_picture;
  if (all(lessThan(here, size))) {
    vec4 known = vec4(0.0);
    if (all(greaterThanEqual(there, ivec2(0))) && all(lessThan(there, textureSize(picture, 0)))) {
      uvec2 sight = texelFetch(visibility, at, 0).xy;
      if (sight.x != 0u) {
        known = vec4(texelFetch(picture, there, 0).rgb, 1.0);
        atomicAdd(seen_here, 1u);
      }
      if (sight.y != 0u) atomicAdd(shown_here, 1u);
    }
    imageStore(known_out, ivec3(here, 0), known.rgaa);
    imageStore(known_out, ivec3(here, 1), vec4(known.b, 0.0, known.a, 0.0));
  }
  synchronize();
  if (gl_LocalInvocationIndex != 0u || shown_here == 0u) return;
  atomicAdd(shown, shown_here);
  atomicAdd(seen, seen_here);
}
