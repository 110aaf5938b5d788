// False colours of the intermediates. The numbers are RenderOutput's.
const int kWeights = 1, kVisibility = 2, kSoftVisibility = 3, kFlow = 4, kGhosting = 5, kDepth = 6, kOpacity = 7,
          kProjected = 8, kAliasing = 9, kPredicted = 10, kWarped = 11, kPositionWeights = 12, kColorWeights = 13,
          kField = 14, kConfidence = 15, kMeasured = 16;

vec3 hue(float h) { return clamp(abs(fract(h + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0); }

// One colour a camera, the same from every view.
vec3 camera_color(int index) { return 0.25 + 0.75 * hue(fract(0.11 + 0.618034 * cameras[index].image.z)); }

// Black, red, yellow, white over 0…1.
vec3 heat(float x) { return clamp(vec3(3.0 * x, 3.0 * x - 1.0, 3.0 * x - 2.0), 0.0, 1.0); }

// Hue: direction; full at 8 px.
vec3 flow_color(vec2 uv) {
  return mix(vec3(1.0), hue(atan(uv.y, uv.x) / 6.2831853), min(length(uv) / 8.0, 1.0));
}

// White at 1, blue towards 1/4, red towards 4.
vec3 spacing_color(float spacing) {
  float octaves = clamp(log2(max(spacing, 1e-6)) / 2.0, -1.0, 1.0), rest = 1.0 - abs(octaves);
  return vec3(octaves < 0.0 ? rest : 1.0, rest, octaves > 0.0 ? rest : 1.0);
}

// What two photographs do to a point: render/inspection.h.
const int kSharp = 0, kBlurred = 1, kGhost = 2;
const float kSharpSpacing = 1.2247449;
int blend_class(float apart, float spacing, float other_spacing) {
  if (apart > 1.0) return apart > min(spacing, other_spacing) ? kGhost : kBlurred;
  return max(spacing, other_spacing) > kSharpSpacing ? kBlurred : kSharp;
}
vec3 class_color(int of_blend) {
  return (of_blend == kSharp     ? vec3(64.0, 176.0, 80.0)
          : of_blend == kBlurred ? vec3(64.0, 96.0, 224.0)
                                 : vec3(224.0, 48.0, 48.0)) / 255.0;
}
