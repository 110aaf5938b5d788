layout(location = 0) in float z;
layout(location = 0) out float depth;
void main() { depth = z; }
