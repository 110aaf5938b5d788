// What a kernel over the window draws: its pixels lie in the picture, what is beyond it is lost.
layout(binding = 0) writeonly uniform image2D target;
layout(location = 0) uniform ivec2 window_in_target;

void draw(ivec2 at, vec4 color) { imageStore(target, at + window_in_target, color); }
