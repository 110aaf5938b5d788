// Patches of a zipmap over one another, in front of its root or of what was drawn before (thesis 5.2); the
// sum of render/zipmap/zipmap.cpp, with opacity, so that passes can be laid over one another.

layout(location = 0) uniform mat3 uv_from_pixel;
layout(location = 1) uniform ivec2 range;     // first patch of this pass, and how many
layout(location = 2) uniform int wrap;        // Zipmap::Wrap
layout(location = 3) uniform bool with_root;  // the first pass
layout(location = 4) uniform vec4 root_tint;  // rgb, and how much of the picture it hides
layout(location = 5) uniform vec3 rim_tint;   // of what is not opaque
layout(location = 6) uniform int plain_from;  // columns from this one on show the root alone

layout(binding = 0) uniform sampler2DArray root;      // red, green, blue
layout(binding = 1) uniform sampler2DArray pictures;  // level l of a picture lies in the corner of level l

struct Patch {
  vec4 rows[3];  // of patch_from_root
  ivec4 place;   // layer, width, height, the finest level that is there
  vec4 tint;     // rgb; w: the last level
};
layout(std430, binding = 0) readonly buffer Patches { Patch patches[]; };

layout(location = 0) out vec4 color;

const float kHorizon = 1e-9;

float wrapped(float x) {
  if (wrap == 1) return clamp(x, 0.0, 1.0);
  if (wrap == 0) return fract(x);
  float t = mod(abs(x), 2.0);
  return t < 1.0 ? t : 2.0 - t;
}

float level_of_detail(vec2 size, vec2 du, vec2 dv) {
  return log2(max(max(length(du * size), length(dv * size)), 1e-12));
}

// Fetched one by one: a driver may choose the level of textureLod() for four pixels at once, and then some of
// them would be read at coordinates of another level. Beyond the picture lies what belongs to nobody.
vec4 at_level(Patch p, vec2 uv, int level) {
  ivec2 size = max(p.place.yz >> level, ivec2(1));
  vec2 texel = uv * vec2(size) - 0.5;
  ivec2 low = ivec2(floor(texel));
  vec2 part = texel - vec2(low);
  ivec2 a = clamp(low, ivec2(0), size - 1), b = clamp(low + 1, ivec2(0), size - 1);
  int layer = p.place.x;
  vec4 above = mix(texelFetch(pictures, ivec3(a, layer), level),
                   texelFetch(pictures, ivec3(b.x, a.y, layer), level), part.x);
  vec4 below = mix(texelFetch(pictures, ivec3(a.x, b.y, layer), level),
                   texelFetch(pictures, ivec3(b, layer), level), part.x);
  return mix(above, below, part.y);
}

vec4 sampled(Patch p, vec2 uv, float lod) {
  float at = clamp(lod, float(p.place.w), p.tint.w);
  int fine = int(at);
  float between = at - float(fine);
  vec4 near = at_level(p, uv, fine);
  return between == 0.0 ? near : mix(near, at_level(p, uv, fine + 1), between);
}

void main() {
  vec3 p = uv_from_pixel * vec3(gl_FragCoord.xy, 1.0);
  color = with_root ? vec4(0.0, 0.0, 0.0, 1.0) : vec4(0.0);
  if (!(p.z > kHorizon)) return;
  vec2 uv = p.xy / p.z;
  vec2 du = (uv_from_pixel[0].xy - uv * uv_from_pixel[0].z) / p.z;
  vec2 dv = (uv_from_pixel[1].xy - uv * uv_from_pixel[1].z) / p.z;
  vec3 inside = vec3(wrapped(uv.x), wrapped(uv.y), 1.0);
  if (with_root) {
    float lod = level_of_detail(vec2(textureSize(root, 0).xy), du, dv);
    for (int c = 0; c < 3; ++c) color[c] = textureLod(root, vec3(inside.xy, c), lod).r;
    if (gl_FragCoord.x < plain_from) color.rgb = mix(color.rgb, root_tint.rgb, root_tint.a);
  }
  if (gl_FragCoord.x >= plain_from) return;
  for (int i = range.x; i < range.x + range.y; ++i) {
    Patch patch_ = patches[i];
    vec3 q = vec3(dot(patch_.rows[0].xyz, inside), dot(patch_.rows[1].xyz, inside),
                  dot(patch_.rows[2].xyz, inside));
    if (!(q.z > kHorizon)) continue;
    vec2 at = q.xy / q.z;
    if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(1.0)))) continue;
    vec2 x = vec2(patch_.rows[0].x, patch_.rows[1].x) - at * patch_.rows[2].x;
    vec2 y = vec2(patch_.rows[0].y, patch_.rows[1].y) - at * patch_.rows[2].y;
    float lod = level_of_detail(vec2(patch_.place.yz), (x * du.x + y * du.y) / q.z,
                                (x * dv.x + y * dv.y) / q.z);
    vec4 c = sampled(patch_, at, lod);
    vec3 tint = c.a > 0.99 ? patch_.tint.rgb : rim_tint;
    c.rgb = mix(c.rgb, tint, root_tint.a);
    color = color * (1.0 - c.a) + vec4(c.rgb * c.a, c.a);
  }
}
