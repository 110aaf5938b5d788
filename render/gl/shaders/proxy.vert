layout(location = 0) in vec3 position;
layout(location = 0) out vec3 world;
layout(location = 1) out float z;
void main() {
  world = position;
  gl_Position = view.clip_from_world * vec4(position, 1.0);
  z = gl_Position.w;
}
