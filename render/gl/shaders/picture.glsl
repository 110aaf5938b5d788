// A kernel that draws the picture: one invocation a pixel of it. The window may lie anywhere in it, and reach beyond.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) writeonly uniform image2D picture_out;
layout(binding = 1) uniform sampler2D surface;
layout(location = 0) uniform ivec2 window_in_picture;

void draw(vec4 color) { imageStore(picture_out, ivec2(gl_GlobalInvocationID.xy), color); }
void draw_background() { draw(vec4(view.background.rgb, 0.0)); }

// This invocation's pixel, in the window; it may lie beside it.
ivec2 pixel_here() { return ivec2(gl_GlobalInvocationID.xy) - window_in_picture; }

// The surface there. False: there is none.
bool surface_here(out ivec2 at, out vec4 here) {
  at = pixel_here();
  here = in_window(at) ? texelFetch(surface, at, 0) : vec4(kNothing);
  return here.w < kNothing;
}
