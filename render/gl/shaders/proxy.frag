// The proxy from the view: the triangle's normal (towards the viewer) and z.
layout(location = 0) in vec3 world;
layout(location = 1) in float z;
layout(location = 0) out vec4 surface;
void main() {
  vec3 n = cross(dFdx(world), dFdy(world));
  float length2 = dot(n, n);
  n = length2 > 0.0 ? n * inversesqrt(length2) : normalize(view.view_center.xyz - world);
  if (dot(n, view.view_center.xyz - world) < 0.0) n = -n;
  surface = vec4(n, z);
}
