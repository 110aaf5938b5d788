// The four cameras around where the viewing ray meets the cameras' plane, weighted bilinearly. The twin of
// render/light_field.cpp and render/cpu/light_field_renderer.cpp.
layout(location = 1) uniform ivec2 grid;  // columns, rows
layout(location = 2) uniform vec3 plane[3];  // normal, right, down
layout(location = 5) uniform vec3 eye;  // before the plane, and on it: right, down
layout(location = 6) uniform int last_level;  // of the photographs' pyramids that this view reads
layout(std430, binding = 1) readonly buffer Grid { float places[]; };  // of columns, of rows; cameras row after row

const float kBeside = 1e-6, kParallel = 1e-6;

int between(int first, int count, float at, out float share) {
  int i = 0;
  while (i + 2 < count && places[first + i + 1] <= at) ++i;
  share = clamp((at - places[first + i]) / (places[first + i + 1] - places[first + i]), 0.0, 1.0);
  return i;
}

void main() {
  ivec2 at;
  vec4 here;
  if (!surface_here(at, here)) {
    draw_background();
    return;
  }
  vec2 pixel = vec2(at) + 0.5, share;
  vec3 world = world_at(pixel, here.w), way = mat3(view.world_from_view) * view_ray(pixel);
  float along = dot(plane[0], way), steps = eye.x / (abs(along) > kParallel ? along : kParallel);
  int column = between(0, grid.x, eye.y - steps * dot(plane[1], way), share.x);
  int row = between(grid.x, grid.y, eye.z - steps * dot(plane[2], way), share.y);
  vec3 sum = vec3(0.0), colors[4];
  float total = 0.0, weights[4];
  for (int k = 0; k < 4; ++k) {
    ivec2 corner = ivec2(k & 1, k >> 1);
    vec2 side = mix(1.0 - share, share, vec2(corner));
    weights[k] = side.x * side.y;
    colors[k] = vec3(0.0);
    if (weights[k] == 0.0) continue;
    int index = int(places[grid.x + grid.y + (row + corner.y) * grid.x + column + corner.x]);
    vec2 p;
    if (!photo_pixel(index, (cameras[index].cam_from_world * vec4(world, 1.0)).xyz, p)) weights[k] *= kBeside;
    float area = last_level > 0 ? footprint(index, pixel, here.xyz, here.w) : 0.0;
    colors[k] = photo_color(index, p, area);
    sum += weights[k] * colors[k];
    total += weights[k];
  }
  vec3 mean = sum / max(total, 1e-12);
  vec4 color = vec4(mean, 1.0);
  if (view.counts.w == kGhosting) {
    float apart = 0.0;
    for (int k = 0; k < 4; ++k)
      if (weights[k] > 0.0) apart += weights[k] / total * distance(colors[k], mean);
    color.rgb = heat(3.0 * apart);
  }
  draw(color);
}
