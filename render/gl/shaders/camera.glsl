// The photographs' cameras. Mirrors CameraBlock in render/camera_block.h.
struct Camera {
  mat4 cam_from_world;
  vec4 center;      // world
  vec4 intrinsics;  // fx, fy, cx, cy
  vec4 lens;        // Brown-Conrady k1 k2 p1 p2, or fisheye k1 k2 k3 k4
  vec4 lens_more;   // Brown-Conrady k3, skew, largest r² the lens is good for, lens type
  vec4 lens_below;  // Brown-Conrady k4 k5 k6: the radial factor's denominator; unused
  vec4 image;       // width, height, layer, unused
  vec4 depth;       // depth map pixel = xy * (x/z, y/z) + zw
  vec4 tile;        // the part of the picture in its layer: x, y, width, height
};
layout(std430, binding = 0) readonly buffer Cameras { Camera cameras[]; };

layout(binding = 0) uniform sampler2DArray photographs;

const float kPinhole = 0.0, kBrownConrady = 1.0;

// Where the lens puts a point of camera coordinates: exact, so photographs are never resampled. False: not in the
// picture.
bool photo_pixel(int index, vec3 p, out vec2 pixel) {
  pixel = vec2(-1.0);
  if (p.z <= 0.0) return false;
  vec2 n = p.xy / p.z;
  vec4 more = cameras[index].lens_more;
  if (more.w != kPinhole) {
    vec4 l = cameras[index].lens;
    float r2 = dot(n, n);
    if (r2 > more.z) return false;
    if (more.w == kBrownConrady) {
      float radial = 1.0 + r2 * (l.x + r2 * (l.y + r2 * more.x));
      vec4 b = cameras[index].lens_below;
      radial /= 1.0 + r2 * (b.x + r2 * (b.y + r2 * b.z));
      n = n * radial + vec2(2.0 * l.z * n.x * n.y + l.w * (r2 + 2.0 * n.x * n.x),
                            l.z * (r2 + 2.0 * n.y * n.y) + 2.0 * l.w * n.x * n.y);
    } else if (r2 > 1e-12) {
      float r = sqrt(r2), t = atan(r), q = t * t;
      n *= t * (1.0 + q * (l.x + q * (l.y + q * (l.z + q * l.w)))) / r;
    }
  }
  vec4 k = cameras[index].intrinsics;
  pixel = vec2(k.x * n.x + more.y * n.y + k.z, k.y * n.y + k.w);
  vec2 size = cameras[index].image.xy;
  return all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, size));
}

const int kLastLevel = 5;  // of the photographs' pyramid

// Levels lie beside their photograph, one below the other: with mipmaps llvmpipe would read one level for four
// neighbouring pixels. gl/scene_textures.cpp puts them there.
vec2 level_size(int index, int level) {
  float shrink = float(1 << level);
  return floor((cameras[index].tile.zw + shrink - 1.0) / shrink);
}

vec2 level_place(int index, int level) {
  if (level == 0) return vec2(0.0);
  vec2 size = cameras[index].tile.zw;
  return vec2(size.x, floor(size.y * (1.0 - 1.0 / float(1 << (level - 1)))) + float(level));
}

// Where a pixel of the photograph lies in a level.
vec2 in_level(int index, vec2 pixel, int level) {
  vec2 at = (pixel - cameras[index].tile.xy) / float(1 << level);
  return clamp(at, vec2(0.5), level_size(index, level) - 0.5);
}

// Colour and opacity (the matte) of a photograph at a pixel, bilinear, from a level of its pyramid.
vec4 photo_at(int index, vec2 pixel, int level) {
  vec2 at = level_place(index, level) + in_level(index, pixel, level);
  return textureLod(photographs, vec3(at / vec2(textureSize(photographs, 0).xy), cameras[index].image.z), 0.0);
}

vec4 photo(int index, vec2 pixel) { return photo_at(index, pixel, 0); }

// The colour alone, by a Catmull-Rom spline in nine bilinear reads: what is blended keeps its sharpness.
vec3 photo_color_at(int index, vec2 pixel, int level) {
  if (view.background.w > 0.5) return photo_at(index, pixel, level).rgb;
  pixel = in_level(index, pixel, level);
  vec2 texel = 1.0 / vec2(textureSize(photographs, 0).xy);
  vec2 low = floor(pixel - 0.5) + 0.5, f = pixel - low, place = level_place(index, level);
  vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f)), w1 = 1.0 + f * f * (1.5 * f - 2.5);
  vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f)), w3 = f * f * (0.5 * f - 0.5);
  vec2 w12 = w1 + w2;
  vec2 border = level_size(index, level) - 0.5;
  vec2 x0 = (place + max(low - 1.0, vec2(0.5))) * texel, x12 = (place + min(low + w2 / w12, border)) * texel;
  vec2 x3 = (place + min(low + 2.0, border)) * texel;
  float layer = cameras[index].image.z;
  vec3 sum = (textureLod(photographs, vec3(x0.x, x0.y, layer), 0.0).rgb * w0.x +
              textureLod(photographs, vec3(x12.x, x0.y, layer), 0.0).rgb * w12.x +
              textureLod(photographs, vec3(x3.x, x0.y, layer), 0.0).rgb * w3.x) * w0.y +
             (textureLod(photographs, vec3(x0.x, x12.y, layer), 0.0).rgb * w0.x +
              textureLod(photographs, vec3(x12.x, x12.y, layer), 0.0).rgb * w12.x +
              textureLod(photographs, vec3(x3.x, x12.y, layer), 0.0).rgb * w3.x) * w12.y +
             (textureLod(photographs, vec3(x0.x, x3.y, layer), 0.0).rgb * w0.x +
              textureLod(photographs, vec3(x12.x, x3.y, layer), 0.0).rgb * w12.x +
              textureLod(photographs, vec3(x3.x, x3.y, layer), 0.0).rgb * w3.x) * w3.y;
  return clamp(sum, 0.0, 1.0);
}
