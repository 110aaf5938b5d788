// A kernel over the window: one invocation a pixel of it.
layout(local_size_x = 8, local_size_y = 8) in;

ivec2 window_pixel() { return ivec2(gl_GlobalInvocationID.xy); }
