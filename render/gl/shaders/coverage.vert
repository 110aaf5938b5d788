// The proxy alone: whether it is there.
layout(location = 0) in vec3 position;
void main() { gl_Position = view.clip_from_world * vec4(position, 1.0); }
