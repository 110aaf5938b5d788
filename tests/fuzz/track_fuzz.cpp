// A media file of a take, from its first byte to its pixels: 8x8 Rgb8 pictures in FFV1, raw or H.264 by the
// first byte.

#include <algorithm>
#include <array>
#include <cstdint>

#include <sys/mman.h>
#include <unistd.h>

#include "capture/track_reader.h"
#include "core/check.h"
#include "core/text.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  if (size == 0) return 0;
  const int fd = ::memfd_create("fuzz", MFD_CLOEXEC);
  FLOATSTAGE_CHECK(fd >= 0 && ::write(fd, data + 1, size - 1) == static_cast<ssize_t>(size - 1),
                   "no memory file");
  constexpr const char* kCodecs[] = {"ffv1", "raw", "h264"};
  TakeManifest::Camera camera{"cam0", "fuzz", kCodecs[data[0] % 3], PixelFormat::Rgb8, 8, 8};
  if (auto track = capture::TrackReader::open(text("/proc/self/fd/", fd), camera)) {
    const std::int64_t last = std::min<std::int64_t>((*track)->pictures(), 16);
    for (std::int64_t i = last - 1; i >= 0; --i) {
      const auto picture = (*track)->picture(i);
      FLOATSTAGE_CHECK(picture || picture.error().code == ErrorCode::BadData, "an error of another kind");
      FLOATSTAGE_CHECK(!picture || *picture != nullptr, "no pixels and no error");
      const auto part = (*track)->part(i, std::array{PixelBox{static_cast<int>(i % 4), 2, 3, 4}});
      FLOATSTAGE_CHECK(part || part.error().code == ErrorCode::BadData, "an error of another kind");
    }
  }
  ::close(fd);
  return 0;
}
