// A picture over the pictures before: what was there keeps its share (accumulation, ch. 10).
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1) uniform sampler2D now;
layout(binding = 2) uniform sampler2D before;
layout(binding = 0) writeonly uniform image2D sum;
layout(binding = 1) writeonly uniform image2D shown;
layout(location = 0) uniform float share;

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at, textureSize(now, 0)))) return;
  vec4 color = texelFetch(now, at, 0);
  if (share > 0.0) color = mix(color, texelFetch(before, at, 0), share);
  imageStore(sum, at, color);
  imageStore(shown, at, color);
}
