// Several sweeps of red-black SOR on the increment of the field, in shared memory. A tile is worked on with two pixels
// more on every side a sweep: wrong values come in from the border by one pixel each half-sweep and do not reach what
// is written, which is therefore what as many sweeps over the whole picture give. Even and odd pixels of the
// checkerboard lie apart, so that neighbouring invocations read neighbouring memory.
layout(local_size_x = 32, local_size_y = 32) in;
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

const int kSide = 64, kPairs = kSide / 2, kRows = 32, kEach = 2 * kSide / kRows;
const float kLeastDeterminant = 1e-20;

shared vec2 values[2 * kSide * kPairs];  // [color][row][pair of columns]

// The i-th of an invocation's pixels: both colours of a pair, in every kRows-th row.
int color_of(int i) { return i & 1; }
int row_of(int i) { return int(gl_LocalInvocationID.y) + kRows * (i >> 1); }
int shift_of(int i) { return row_of(i) + color_of(i) & 1; }  // of a pair's two pixels, which
int column_of(int i) { return 2 * int(gl_LocalInvocationID.x) + shift_of(i); }
int slot(int color, int i) { return (color * kSide + row_of(i)) * kPairs + int(gl_LocalInvocationID.x); }
// Of the four neighbours, which have the other colour: of a pair's two pixels the even one has its left neighbour in
// the pair before.
int right_of(int i) { return slot(1 - color_of(i), i) + shift_of(i); }
int left_of(int i) { return right_of(i) - 1; }
int below(int i) { return slot(1 - color_of(i), i) + kPairs; }
int above(int i) { return slot(1 - color_of(i), i) - kPairs; }

// What the neighbours pull by. Those that are not coupled are not read: they may hold anything.
vec2 pulled(int i, vec4 springs) {
  vec2 sum = vec2(0.0);
  if (springs.x > 0.0) sum += springs.x * values[right_of(i)];
  if (springs.y > 0.0) sum += springs.y * values[left_of(i)];
  if (springs.z > 0.0) sum += springs.z * values[below(i)];
  if (springs.w > 0.0) sum += springs.w * values[above(i)];
  return sum;
}

void main() {
  ivec2 tile;
  int field;
  if (!work(tile, field)) return;
  ivec2 origin = tile * side - halo;

  // Everything is asked for before anything is used.
  vec4 tensors[kEach], sides[kEach];
  vec2 own[kEach];
  for (int i = 0; i < kEach; ++i) {
    ivec3 at = ivec3(clamp(origin + ivec2(column_of(i), row_of(i)), ivec2(0), size - 1), field);
    tensors[i] = texelFetch(tensor_and_right, at, 0);
    sides[i] = texelFetch(sides_and_down, at, 0);
    own[i] = first ? vec2(0.0) : texelFetch(increment, at, 0).xy;
  }
  // A pixel knows its springs to the right and down; those to the left and up are its neighbours'.
  for (int i = 0; i < kEach; ++i) {
    ivec2 p = origin + ivec2(column_of(i), row_of(i));
    if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) {
      tensors[i] = sides[i] = vec4(0.0);
      own[i] = vec2(0.0);
    }
    values[slot(color_of(i), i)] = vec2(tensors[i].w, sides[i].z);
  }
  synchronize();
  vec4 springs[kEach];  // to the right, left, below, above; none beyond the tile
  for (int i = 0; i < kEach; ++i) {
    springs[i] = vec4(0.0);
    if (sides[i].w == 0.0) continue;
    if (column_of(i) < kSide - 1) springs[i].x = tensors[i].w;
    if (column_of(i) > 0) springs[i].y = values[left_of(i)].x;
    if (row_of(i) < kSide - 1) springs[i].z = sides[i].z;
    if (row_of(i) > 0) springs[i].w = values[above(i)].y;
  }
  synchronize();
  vec3 inverse[kEach];  // i11, i12, i22; holds omega
  for (int i = 0; i < kEach; ++i) {
    values[slot(color_of(i), i)] = own[i];
    inverse[i] = vec3(omega, 0.0, omega);
    if (sides[i].w == 0.0) continue;
    vec4 t = tensors[i];
    float pull = (springs[i].x + springs[i].y) + (springs[i].z + springs[i].w);
    // The determinant of J alone is a difference of large numbers: it may not fall below 0.
    float determinant = max(t.x * t.z - t.y * t.y, 0.0);
    float scale = omega / max(determinant + pull * ((t.x + t.z) + pull), kLeastDeterminant);
    inverse[i] = vec3(t.z + pull, t.y, t.x + pull) * scale;
  }
  synchronize();
  for (int s = 0; s < sweeps; ++s)
    for (int color = 0; color < 2; ++color) {
      for (int k = 0; k < kEach / 2; ++k) {
        int i = 2 * k + color;
        vec2 sum = sides[i].xy + pulled(i, springs[i]);
        vec3 m = inverse[i];
        own[i] = (1.0 - omega) * own[i] + vec2(m.x * sum.x - m.y * sum.y, m.z * sum.y - m.y * sum.x);
        values[slot(color, i)] = own[i];
      }
      synchronize();
    }
  for (int i = 0; i < kEach; ++i) {
    ivec2 local = ivec2(column_of(i), row_of(i)) - halo, p = tile * side + local;
    if (any(lessThan(local, ivec2(0))) || any(greaterThanEqual(local, ivec2(side))) || any(greaterThanEqual(p, size)))
      continue;
    vec2 base = last ? texelFetch(field_uv, ivec3(p, field), 0).xy : vec2(0.0);
    imageStore(result, ivec3(p, field), vec4(base + own[i], 0.0, 0.0));
  }
}
