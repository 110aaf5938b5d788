// RIFF: Microsoft's Multimedia Programming Interface 1.0; RF64 and BW64: EBU Tech 3306, ITU-R BS.2088.

#include "capture/sound/wav_length.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <string_view>

#include <unistd.h>

#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr std::uint32_t kUnstated = 0xFFFFFFFF;
constexpr int kMostChunks = 1000;

class Wav {
 public:
  Wav(const std::filesystem::path& file, int descriptor) : file_(file), descriptor_(descriptor) {}

  Result<bool> read(std::uint64_t at, std::span<char> to) const {
    for (std::size_t done = 0; done < to.size();) {
      const ssize_t n =
          ::pread(descriptor_, to.data() + done, to.size() - done, static_cast<off_t>(at + done));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return fail(ErrorCode::Io, text("cannot read ", file_.string(), ": ", std::strerror(errno)));
      if (n == 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  }

 private:
  const std::filesystem::path& file_;
  const int descriptor_;
};

template <class T>
T number(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

}  // namespace

Result<void> check_wav_length(const std::filesystem::path& file) {
  const Result<FileDescriptor> open = open_to_read(file);
  if (!open) return forward(open);
  const Result<std::uint64_t> size = size_of(*open, file);
  if (!size) return forward(size);
  const Wav wav(file, open->get());
  std::array<char, 12> head = {};
  const Result<bool> headed = wav.read(0, head);
  if (!headed) return forward(headed);
  const std::string_view kind(head.data(), 4);
  const bool large = kind == "RF64" || kind == "BW64";
  if (!*headed || (kind != "RIFF" && !large) || std::string_view(head.data() + 8, 4) != "WAVE") return {};
  std::uint64_t large_size = kUnstated;
  std::uint64_t at = head.size();
  for (int i = 0; i < kMostChunks; ++i) {
    std::array<char, 8> chunk = {};
    const Result<bool> there = wav.read(at, chunk);
    if (!there) return forward(there);
    if (!*there) return {};  // no sound at all is said by others
    const std::string_view name(chunk.data(), 4);
    std::uint64_t bytes = number<std::uint32_t>(chunk.data() + 4);
    at += chunk.size();
    if (large && name == "ds64") {
      std::array<char, 16> sizes = {};
      const Result<bool> stated = wav.read(at, sizes);
      if (!stated) return forward(stated);
      if (*stated) large_size = number<std::uint64_t>(sizes.data() + 8);
    }
    if (name == "data") {
      if (bytes == kUnstated) bytes = large_size;
      const std::uint64_t held = *size - std::min<std::uint64_t>(at, *size);
      if (bytes == kUnstated) return {};
      if (bytes == 0 && held > 0)
        return fail(ErrorCode::BadData,
                    text(file.string(), ": states that it holds no sound, but ", held,
                         " bytes follow: its recorder was not stopped. Write it anew (ffmpeg -ignore_length "
                         "1 -i IN.wav OUT.wav) and hear it to its end"));
      if (bytes > held)
        return fail(ErrorCode::BadData,
                    text(file.string(), ": is cut off: it states ", bytes, " bytes of sound and holds ", held,
                         "; copy it from its recorder again"));
    }
    at += bytes + (bytes & 1U);
  }
  return fail(ErrorCode::BadData,
              text(file.string(), ": holds more than ", kMostChunks,
                   " chunks, or bytes that are none; write it anew (ffmpeg -i IN.wav OUT.wav)"));
}

}  // namespace floatstage::capture
