// The picture, of which what nobody sees is continued from around it. The twin of render/cpu/unseen.cpp.
layout(binding = 2) uniform sampler2DArray known;   // unseen_known.comp
layout(binding = 3) uniform sampler2DArray around;  // fill_push.comp
layout(binding = 4) uniform sampler2D picture;
layout(binding = 5) uniform sampler2DArray all;     // of one pixel: whether anything is known
layout(location = 1) uniform ivec2 around_size;
layout(location = 2) uniform int margin;

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec4 color = texelFetch(picture, ivec2(gl_GlobalInvocationID.xy), 0);
  if (texelFetch(all, ivec3(0), 0).z > 0.0) {
    color.rg = filled(known, around, ivec3(at - margin, 0), around_size);
    color.b = filled(known, around, ivec3(at - margin, 1), around_size).x;
  }
  draw(color);
}
