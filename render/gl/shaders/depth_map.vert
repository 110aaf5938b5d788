// The proxy as a photograph's camera sees it, in ideal pinhole coordinates.
layout(location = 0) in vec3 position;
layout(location = 0) uniform mat4 cam_from_world;
layout(location = 1) uniform vec4 depth_window;  // depth map pixel = xy * (x/z, y/z) + zw
layout(location = 2) uniform vec4 size_and_planes;  // depth map width and height, near and far
layout(location = 0) out float z;
void main() {
  vec3 p = (cam_from_world * vec4(position, 1.0)).xyz;
  z = p.z;
  vec2 pixel = depth_window.xy * p.xy + depth_window.zw * p.z;
  float near = size_and_planes.z, far = size_and_planes.w;
  vec2 clip = 2.0 * pixel / size_and_planes.xy - p.z;  // y is up in clip space, down in pictures
  gl_Position = vec4(clip.x, -clip.y, far * (p.z - near) / (far - near), p.z);
}
