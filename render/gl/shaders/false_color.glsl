// False colours of the intermediates. The numbers are RenderOutput's.
const int kWeights = 1, kVisibility = 2, kSoftVisibility = 3, kFlow = 4, kGhosting = 5, kDepth = 6, kOpacity = 7;

vec3 hue(float h) { return clamp(abs(fract(h + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0); }

// One colour a camera, the same from every view.
vec3 camera_color(int index) { return 0.25 + 0.75 * hue(fract(0.11 + 0.618034 * cameras[index].image.z)); }

// Black, red, yellow, white over 0…1.
vec3 heat(float x) { return clamp(vec3(3.0 * x, 3.0 * x - 1.0, 3.0 * x - 2.0), 0.0, 1.0); }
