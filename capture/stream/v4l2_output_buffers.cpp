#include "capture/stream/v4l2_output_buffers.h"

#include <cerrno>
#include <cstring>

#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

namespace floatstage::capture {
namespace {

constexpr std::uint32_t kBuffers = 2;  // one shown, one filled: more would be latency

int ask(int device, unsigned long request, void* argument) {
  for (;;) {
    if (::ioctl(device, request, argument) == 0) return 0;
    if (errno != EINTR) return errno;
  }
}

v4l2_buffer any_buffer() {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  buffer.memory = V4L2_MEMORY_MMAP;
  return buffer;
}

}  // namespace

V4l2OutputBuffers::~V4l2OutputBuffers() {
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  if (streams_) ask(device_, VIDIOC_STREAMOFF, &type);
  for (const std::span<std::uint8_t> map : maps_) ::munmap(map.data(), map.size());
}

int V4l2OutputBuffers::start(int device) {
  device_ = device;
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = ask(device_, VIDIOC_REQBUFS, &request); error != 0) return error;
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = any_buffer();
    buffer.index = i;
    if (const int error = ask(device_, VIDIOC_QUERYBUF, &buffer); error != 0) return error;
    void* map = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, device_, buffer.m.offset);
    if (map == MAP_FAILED) return errno;
    maps_.emplace_back(static_cast<std::uint8_t*>(map), buffer.length);
  }
  return maps_.empty() ? ENOMEM : 0;
}

int V4l2OutputBuffers::put(std::span<const std::uint8_t> picture) {
  v4l2_buffer buffer = any_buffer();
  buffer.index = static_cast<std::uint32_t>(used_);
  const bool unused = used_ < maps_.size();
  if (!unused)
    if (const int error = ask(device_, VIDIOC_DQBUF, &buffer); error != 0) return error;
  if (buffer.index >= maps_.size() || maps_[buffer.index].size() < picture.size()) return EMSGSIZE;
  std::memcpy(maps_[buffer.index].data(), picture.data(), picture.size());
  v4l2_buffer full = any_buffer();
  full.index = buffer.index;
  full.bytesused = static_cast<std::uint32_t>(picture.size());
  full.field = V4L2_FIELD_NONE;
  if (const int error = ask(device_, VIDIOC_QBUF, &full); error != 0) return error;
  if (unused) ++used_;
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  const int error = streams_ ? 0 : ask(device_, VIDIOC_STREAMON, &type);
  streams_ = error == 0;
  return error;
}

}  // namespace floatstage::capture
