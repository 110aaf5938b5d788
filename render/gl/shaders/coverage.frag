layout(location = 0) out vec4 samples;  // one channel is written
void main() { samples = vec4(1.0); }
