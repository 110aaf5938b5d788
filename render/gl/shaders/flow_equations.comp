// One warp: the second picture is read where the field points to, the energy is linearised there, and every pixel gets
// its equations for the increment of the field (flow_kernels_scalar.cpp: warp … equations). The CPU's equations are for
// the field itself; the increment is small and keeps its precision in half floats (docs/adr/0167).
layout(binding = 1) uniform sampler2DArray field_uv;
layout(binding = 2) uniform usampler2DArray samples;
layout(binding = 3) uniform sampler2DArray stiffness_and_data;
layout(binding = 0) writeonly uniform image2DArray tensor_and_right;  // j11, j12, j22, weight to the right
layout(binding = 1) writeonly uniform image2DArray sides_and_down;    // r1, r2, weight down, 1 if there is an equation
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform vec4 energy;  // gamma, zeta^2, epsilon^2 of the data, of the smoothness
layout(location = 2) uniform bool by_splines;

const int kHalo = 2, kSide = 32 + 2 * kHalo;
const int kRing = 1, kRingSide = 32 + 2 * kRing;

shared float mean[kSide * kSide], difference[kSide * kSide], evidence[kSide * kSide];
shared float diffusivity[kRingSide * kRingSide];

ivec2 origin;  // of the tile
int field;

vec2 uv_at(ivec2 p) { return texelFetch(field_uv, ivec3(clamp(p, ivec2(0), size - 1), field), 0).xy; }

void warp(int i) {
  ivec2 p = clamp(origin - kHalo + ivec2(i % kSide, i / kSide), ivec2(0), size - 1), pictures = tables.fields[field].xy;
  float first = value_of(texelFetch(samples, ivec3(p, pictures.x), 0).x) * kSampleStep;
  vec2 at = clamp(vec2(p) + uv_at(p), vec2(-1.0), vec2(size)), low = floor(at);
  vec2 s = by_splines ? cubic(samples, ivec2(low), at - low, size, pictures.y)
                      : bilinear(samples, ivec2(low), at - low, size, pictures.y);
  mean[i] = 0.5 * (first + s.x);
  difference[i] = s.x - first;
  evidence[i] = s.y;
}

// Stiffness over what the field's forward differences say; 0 where nothing is coupled.
float diffusivity_at(int i) {
  ivec2 p = origin - kRing + ivec2(i % kRingSide, i / kRingSide);
  if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) return 0.0;
  float stiffness = texelFetch(stiffness_and_data, ivec3(p, tables.fields[field].x), 0).x;
  if (stiffness <= 0.0) return 0.0;
  vec2 here = uv_at(p), dx = uv_at(p + ivec2(1, 0)) - here, dy = uv_at(p + ivec2(0, 1)) - here;
  float squares = (dx.x * dx.x + dy.x * dy.x) + (dx.y * dx.y + dy.y * dy.y);
  return stiffness / sqrt(squares + energy.w);
}

int slot(ivec2 p) {
  ivec2 q = clamp(p, ivec2(0), size - 1) - origin + kHalo;
  return q.y * kSide + q.x;
}
float mean_dx(ivec2 p) {
  p = clamp(p, ivec2(0), size - 1);
  return 0.5 * (mean[slot(p + ivec2(1, 0))] - mean[slot(p - ivec2(1, 0))]);
}
float mean_dy(ivec2 p) {
  p = clamp(p, ivec2(0), size - 1);
  return 0.5 * (mean[slot(p + ivec2(0, 1))] - mean[slot(p - ivec2(0, 1))]);
}

// The data's tensor (j11, j12, j22) and what it pulls by (c1, c2).
void data_terms(ivec2 p, float weight, out vec3 j, out vec2 c) {
  j = vec3(0.0);
  c = vec2(0.0);
  if (weight <= 0.0) return;
  const ivec2 right = ivec2(1, 0), down = ivec2(0, 1);
  float dx = mean_dx(p), dy = mean_dy(p), dt = difference[slot(p)];
  float dxx = 0.5 * (mean_dx(p + right) - mean_dx(p - right)), dxy = 0.5 * (mean_dx(p + down) - mean_dx(p - down));
  float dyy = 0.5 * (mean_dy(p + down) - mean_dy(p - down));
  float dxt = 0.5 * (difference[slot(p + right)] - difference[slot(p - right)]);
  float dyt = 0.5 * (difference[slot(p + down)] - difference[slot(p - down)]);
  float noise2 = energy.y;
  float theta = 1.0 / ((dx * dx + dy * dy) + noise2);
  float theta_x = 1.0 / ((dxx * dxx + dxy * dxy) + noise2), theta_y = 1.0 / ((dxy * dxy + dyy * dyy) + noise2);
  float bright = noise2 * (theta * (dt * dt)), grad = noise2 * (theta_x * (dxt * dxt) + theta_y * (dyt * dyt));
  float scaled = weight * noise2;
  float b = (scaled * theta) / sqrt(bright + energy.z), g = (scaled * energy.x) / sqrt(grad + energy.z);
  float gx = g * theta_x, gy = g * theta_y;
  j = vec3(b * (dx * dx) + (gx * (dxx * dxx) + gy * (dxy * dxy)), b * (dx * dy) + (gx * (dxx * dxy) + gy * (dxy * dyy)),
           b * (dy * dy) + (gx * (dxy * dxy) + gy * (dyy * dyy)));
  c = vec2(b * (dx * dt) + (gx * (dxx * dxt) + gy * (dxy * dyt)), b * (dy * dt) + (gx * (dxy * dxt) + gy * (dyy * dyt)));
}

void equate(ivec2 p) {
  ivec2 q = p - origin + kRing;
  int d = q.y * kRingSide + q.x;
  vec2 here = uv_at(p);
  if (diffusivity[d] <= 0.0) {  // beyond the band: nothing is known and nothing pulls; it goes to 0, as on the CPU
    imageStore(tensor_and_right, ivec3(p, field), vec4(0.0));
    imageStore(sides_and_down, ivec3(p, field), vec4(-here, 0.0, 0.0));
    return;
  }
  float right = sqrt(diffusivity[d] * diffusivity[d + 1]), left = sqrt(diffusivity[d - 1] * diffusivity[d]);
  float down = sqrt(diffusivity[d] * diffusivity[d + kRingSide]), up = sqrt(diffusivity[d - kRingSide] * diffusivity[d]);
  float data = texelFetch(stiffness_and_data, ivec3(p, tables.fields[field].x), 0).y;
  vec3 j;
  vec2 c;
  data_terms(p, data * evidence[slot(p)], j, c);
  vec2 r = ((right * (uv_at(p + ivec2(1, 0)) - here) + left * (uv_at(p - ivec2(1, 0)) - here)) +
            (down * (uv_at(p + ivec2(0, 1)) - here) + up * (uv_at(p - ivec2(0, 1)) - here))) - c;
  imageStore(tensor_and_right, ivec3(p, field), vec4(j, right));
  imageStore(sides_and_down, ivec3(p, field), vec4(r, down, 1.0));
}

void main() {
  ivec2 tile;
  if (!work(tile, field)) return;
  origin = tile * kTile;
  for (int i = int(gl_LocalInvocationIndex); i < kSide * kSide; i += 256) warp(i);
  for (int i = int(gl_LocalInvocationIndex); i < kRingSide * kRingSide; i += 256) diffusivity[i] = diffusivity_at(i);
  synchronize();
  for (int k = 0; k < kRowsEach; ++k) {
    ivec2 p = pixel_of(tile, k);
    if (all(lessThan(p, size))) equate(p);
  }
}
