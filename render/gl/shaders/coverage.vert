// The proxy, moved by part of a pixel.
layout(location = 0) in vec3 position;
layout(location = 0) uniform vec2 moved;  // clip coordinates
void main() {
  gl_Position = view.clip_from_world * vec4(position, 1.0);
  gl_Position.xy += moved * gl_Position.w;
}
