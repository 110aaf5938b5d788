#include "capture/matroska_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <optional>

#include <sys/stat.h>
#include <unistd.h>

#include "core/text.h"

namespace floatstage::capture {
namespace {

// Element identifiers, marker bits included (RFC 9559, section 5).
constexpr std::uint64_t kEbml = 0x1A45DFA3, kSegment = 0x18538067, kCluster = 0x1F43B675, kSimpleBlock = 0xA3,
                        kBlockGroup = 0xA0, kBlock = 0xA1, kReferenceBlock = 0xFB;
constexpr std::uint64_t kUnknownSize = ~0ull;
constexpr unsigned kLacing = 0x06, kKeyframe = 0x80;  // flags of a block

/// A window on the file that moves forward: element headers lie a picture apart, so a little is read at each.
class Window {
 public:
  Window(int fd, std::int64_t file_size) : fd_(fd), file_size_(file_size) {}

  std::int64_t file_size() const { return file_size_; }
  int error() const { return error_; }

  std::optional<std::uint8_t> byte(std::int64_t at) {
    if (at < 0 || at >= file_size_ || error_) return std::nullopt;
    if (at < begin_ || at >= begin_ + filled_) {
      const ssize_t n = ::pread(fd_, bytes_.data(), bytes_.size(), at);
      if (n <= 0) {
        error_ = n < 0 ? errno : 0;
        return std::nullopt;
      }
      begin_ = at;
      filled_ = n;
    }
    return bytes_[static_cast<std::size_t>(at - begin_)];
  }

  /// A variable-length number: the leading zeros of its first byte say how many bytes follow.
  std::optional<std::uint64_t> number(std::int64_t& at, int longest, bool keep_marker) {
    const auto first = byte(at);
    if (!first || *first == 0) return std::nullopt;
    const int length = std::countl_zero(*first) + 1;
    if (length > longest) return std::nullopt;
    const std::uint64_t mask = 0xFFu >> length;
    std::uint64_t value = keep_marker ? *first : *first & mask;
    bool all_ones = (*first & mask) == mask;
    for (int i = 1; i < length; ++i) {
      const auto next = byte(at + i);
      if (!next) return std::nullopt;
      value = value << 8 | *next;
      all_ones = all_ones && *next == 0xFF;
    }
    at += length;
    return all_ones && !keep_marker ? kUnknownSize : value;
  }

 private:
  int fd_;
  std::int64_t file_size_, begin_ = 0, filled_ = 0;
  int error_ = 0;
  std::array<std::uint8_t, 512> bytes_;
};

// A block: track number, 16-bit time, flags, picture. False when it is none.
bool add_block(Window& file, std::int64_t at, std::int64_t end, bool simple, MatroskaIndex& index) {
  const auto track = file.number(at, 8, false);
  const auto flags = track ? file.byte(at + 2) : std::nullopt;
  if (!flags || at + 3 > end || (*flags & kLacing) != 0) return false;
  if (*track != 1) return true;
  index.pictures.push_back({at + 3, end - at - 3, !simple || (*flags & kKeyframe) != 0});
  return true;
}

}  // namespace

Result<MatroskaIndex> index_matroska(int fd) {
  struct stat status = {};
  if (::fstat(fd, &status) != 0) return fail(ErrorCode::Io, text("cannot read: ", std::strerror(errno)));
  Window file(fd, status.st_size);
  MatroskaIndex index;
  std::int64_t at = 0;
  bool first = true;
  while (at < file.file_size()) {
    const auto id = file.number(at, 4, true);
    const auto size = id ? file.number(at, 8, false) : std::nullopt;
    if (!size || (first && *id != kEbml)) {
      index.cut = true;
      break;
    }
    first = false;
    // Containers are entered, not skipped: their children follow.
    if (*id == kSegment || *id == kCluster || *id == kBlockGroup) continue;
    if (*size > static_cast<std::uint64_t>(file.file_size() - at)) {
      index.cut = true;
      break;
    }
    const std::int64_t end = at + static_cast<std::int64_t>(*size);
    if (*id == kReferenceBlock && !index.pictures.empty()) index.pictures.back().keyframe = false;
    if ((*id == kSimpleBlock || *id == kBlock) && !add_block(file, at, end, *id == kSimpleBlock, index)) {
      index.cut = true;
      break;
    }
    at = end;
  }
  if (file.error()) return fail(ErrorCode::Io, text("cannot read: ", std::strerror(file.error())));
  return index;
}

}  // namespace floatstage::capture
