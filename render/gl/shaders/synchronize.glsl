// All invocations of a work group have come here, and see what the others wrote to shared memory.
void synchronize() {
  memoryBarrierShared();
  barrier();
}
