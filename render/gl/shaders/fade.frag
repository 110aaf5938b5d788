// A picture over the pictures before: what was there keeps its share (accumulation, ch. 10).
layout(binding = 1) uniform sampler2D now;
layout(binding = 2) uniform sampler2D before;
layout(location = 0) uniform float share;
layout(location = 0) out vec4 color;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  color = mix(texelFetch(now, at, 0), texelFetch(before, at, 0), share);
}
