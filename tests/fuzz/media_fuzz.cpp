// What `import` and `matte` decode: any picture or video that libav knows, and its sound.

#include <cstdint>

#include <sys/mman.h>
#include <unistd.h>

#include "capture/media_file.h"
#include "capture/sound/media_sound.h"
#include "core/check.h"
#include "core/text.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const int fd = ::memfd_create("fuzz", MFD_CLOEXEC);
  FLOATSTAGE_CHECK(fd >= 0 && ::write(fd, data, size) == static_cast<ssize_t>(size), "no memory file");
  if (auto media = capture::MediaReader::open(text("/proc/self/fd/", fd)))
    for (int i = 0; i < 8; ++i) {
      const Result<Image> picture = (*media)->next();
      if (!picture) break;
      FLOATSTAGE_CHECK(picture->channels == 3 && picture->width > 0 && picture->height > 0, "no RGB");
      FLOATSTAGE_CHECK(picture->pixels.size() == std::size_t{3} * picture->width * picture->height,
                       "an image of another size than it says");
    }
  if (auto sound = capture::MediaSound::open(text("/proc/self/fd/", fd)); sound && *sound)
    for (int i = 0; i < 8; ++i) {
      const auto block = (*sound)->next();
      if (!block) break;
      FLOATSTAGE_CHECK(!block->samples.empty() && block->samples.size() % (*sound)->channels() == 0,
                       "a sample of some channels");
      for (const float level : block->samples) FLOATSTAGE_CHECK(level == level, "a level that is no number");
    }
  ::close(fd);
  return 0;
}
