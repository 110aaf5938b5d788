// Several sweeps of red-black SOR on the increment of the field, in shared memory. A tile is worked on with two pixels
// more on every side a sweep: wrong values come in from the border by one pixel each half-sweep and do not reach what
// is written, which is therefore what as many sweeps over the whole picture give. Even and odd pixels of the
// checkerboard lie apart, so that neighbouring invocations read neighbouring memory.
layout(local_size_x = 32, local_size_y = 16) in;
layout(binding = 1) uniform sampler2DArray tensor_and_right;  // flow_equations.comp
layout(binding = 2) uniform sampler2DArray sides_and_down;
layout(binding = 3) uniform sampler2DArray increment;
layout(binding = 4) uniform sampler2DArray field_uv;
layout(binding = 0) writeonly uniform image2DArray result;
layout(location = 0) uniform ivec2 size;
layout(location = 1) uniform int side;    // of a tile, px; side + 2 halo <= kSide
layout(location = 2) uniform int halo;    // px, even
layout(location = 3) uniform int sweeps;
layout(location = 4) uniform float omega;
layout(location = 5) uniform bool first;  // the increment is still 0
layout(location = 6) uniform bool last;   // result: the field with its increment; else the increment alone

const int kSide = 64, kPairs = kSide / 2, kRows = 16, kRowsEach = kSide / kRows;
const float kLeastDeterminant = 1e-20;

shared vec2 values[2 * kSide * kPairs];  // [color][row][pair of columns]

struct Equation {
  vec4 springs;  // to the right, left, below, above
  vec3 inverse;  // i11, i12, i22; holds omega
  vec2 side;
};

int slot(int color, int row, int pair) {
  return (color * kSide + clamp(row, 0, kSide - 1)) * kPairs + clamp(pair, 0, kPairs - 1);
}

Equation equation_at(ivec2 p, int field) {
  Equation e = Equation(vec4(0.0), vec3(omega, 0.0, omega), vec2(0.0));
  if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) return e;
  vec4 tensor = texelFetch(tensor_and_right, ivec3(p, field), 0), sides = texelFetch(sides_and_down, ivec3(p, field), 0);
  e.side = sides.xy;
  if (sides.w == 0.0) return e;
  e.springs.x = tensor.w;
  e.springs.z = sides.z;
  if (p.x > 0) e.springs.y = texelFetch(tensor_and_right, ivec3(p - ivec2(1, 0), field), 0).w;
  if (p.y > 0) e.springs.w = texelFetch(sides_and_down, ivec3(p - ivec2(0, 1), field), 0).z;
  float pull = (e.springs.x + e.springs.y) + (e.springs.z + e.springs.w);
  // The determinant of J alone is a difference of large numbers: it may not fall below 0.
  float own = max(tensor.x * tensor.z - tensor.y * tensor.y, 0.0);
  float scale = omega / max(own + pull * ((tensor.x + tensor.z) + pull), kLeastDeterminant);
  e.inverse = vec3(tensor.z + pull, tensor.y, tensor.x + pull) * scale;
  return e;
}

// What the four neighbours pull by. Those that are not coupled are not read: they may hold anything.
vec2 pulled(Equation e, int other, int row, int pair, int left) {
  vec2 sum = vec2(0.0);
  if (e.springs.x > 0.0) sum += e.springs.x * values[slot(other, row, pair + left + 1)];
  if (e.springs.y > 0.0) sum += e.springs.y * values[slot(other, row, pair + left)];
  if (e.springs.z > 0.0) sum += e.springs.z * values[slot(other, row + 1, pair)];
  if (e.springs.w > 0.0) sum += e.springs.w * values[slot(other, row - 1, pair)];
  return sum;
}

void main() {
  ivec2 tile;
  int field;
  if (!work(tile, field)) return;
  ivec2 origin = tile * side - halo;
  int pair = int(gl_LocalInvocationID.x), top = int(gl_LocalInvocationID.y);
  Equation equations[2 * kRowsEach];
  vec2 own[2 * kRowsEach];
  for (int k = 0; k < kRowsEach; ++k)
    for (int color = 0; color < 2; ++color) {
      int row = top + kRows * k, i = 2 * k + color;
      ivec2 p = origin + ivec2(2 * pair + ((row + color) & 1), row);
      equations[i] = equation_at(p, field);
      own[i] = vec2(0.0);
      if (!first && all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size)))
        own[i] = texelFetch(increment, ivec3(p, field), 0).xy;
      values[slot(color, row, pair)] = own[i];
    }
  synchronize();
  for (int s = 0; s < sweeps; ++s)
    for (int color = 0; color < 2; ++color) {
      for (int k = 0; k < kRowsEach; ++k) {
        int row = top + kRows * k, i = 2 * k + color;
        // Of a pair's two pixels the even one has its left neighbour in the pair before.
        vec2 sum = equations[i].side + pulled(equations[i], 1 - color, row, pair, ((row + color) & 1) - 1);
        vec3 inverse = equations[i].inverse;
        own[i] = (1.0 - omega) * own[i] + vec2(inverse.x * sum.x - inverse.y * sum.y, inverse.z * sum.y - inverse.y * sum.x);
        values[slot(color, row, pair)] = own[i];
      }
      synchronize();
    }
  for (int k = 0; k < kRowsEach; ++k)
    for (int color = 0; color < 2; ++color) {
      int row = top + kRows * k, i = 2 * k + color;
      ivec2 local = ivec2(2 * pair + ((row + color) & 1), row) - halo, p = tile * side + local;
      if (any(lessThan(local, ivec2(0))) || any(greaterThanEqual(local, ivec2(side))) || any(greaterThanEqual(p, size)))
        continue;
      vec2 base = last ? texelFetch(field_uv, ivec3(p, field), 0).xy : vec2(0.0);
      imageStore(result, ivec3(p, field), vec4(base + own[i], 0.0, 0.0));
    }
}
