// What every pass knows of the view being drawn. Mirrors ViewBlock in render/gl/projection.h.
layout(std140, binding = 0) uniform ViewBlock {
  mat4 clip_from_world;
  mat4 world_from_view;
  vec4 view_center;   // world
  vec4 view_k;        // fx, fy, cx, cy of the whole view, px
  vec4 window;        // x, y of the drawn window in the view, its width and height, px
  vec4 settings;      // skew, soft radius px, depth tolerance m, px of the view a px of the flow
  vec4 background;    // rgb, 1 to read photographs bilinearly
  ivec4 counts;       // listed cameras, chosen cameras (the first of the list), 1 for one camera a pixel, output
  ivec4 camera_list[2];
  vec4 camera_fade[8];  // x: as one of the chosen; y: as a stand-in; z: the last level that is read
} view;

const int kMaxListed = 8;
const float kNothing = 1e30;  // z where the proxy is not

int listed(int slot) { return view.camera_list[slot >> 2][slot & 3]; }

// The ray through a pixel of the window, z = 1, in the view's coordinates.
vec3 view_ray(vec2 window_pixel) {
  vec2 p = window_pixel + view.window.xy - view.view_k.zw;
  float y = p.y / view.view_k.y;
  return vec3((p.x - view.settings.x * y) / view.view_k.x, y, 1.0);
}

vec3 world_at(vec2 window_pixel, float z) {
  return (view.world_from_view * vec4(view_ray(window_pixel) * z, 1.0)).xyz;
}

bool in_window(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(view.window.zw))); }
