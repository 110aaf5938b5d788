#include "studio/messages/matte_runs.h"

#include <algorithm>

namespace floatstage::studio::wire {
namespace {

constexpr std::size_t kMostSingles = 0x7f, kShortRun = 0x3f, kLongRun = 0x3fff;
// A shorter run costs as much as its single bytes.
constexpr std::size_t kLeastRun = 3;

std::size_t run_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t most) {
  const std::size_t end = std::min(bytes.size(), at + most);
  std::size_t last = at + 1;
  while (last < end && bytes[last] == bytes[at]) ++last;
  return last - at;
}

}  // namespace

std::string encode_runs(std::span<const std::uint8_t> bytes) {
  std::string code;
  code.reserve(bytes.size() / 8);
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t run = run_at(bytes, at, kLongRun);
    if (run >= kLeastRun) {
      if (run > kShortRun) {
        code += static_cast<char>(0xc0 | (run >> 8));
        code += static_cast<char>(run & 0xff);
      } else {
        code += static_cast<char>(0x80 | run);
      }
      code += static_cast<char>(bytes[at]);
      at += run;
      continue;
    }
    std::size_t singles = run;
    const std::size_t most = std::min(kMostSingles, bytes.size() - at);
    while (singles < most && run_at(bytes, at + singles, kLeastRun) < kLeastRun) ++singles;
    code += static_cast<char>(singles);
    code.append(reinterpret_cast<const char*>(bytes.data()) + at, singles);
    at += singles;
  }
  return code;
}

Result<std::vector<std::uint8_t>> decode_runs(std::string_view code, std::size_t size) {
  const auto bad = [] { return fail(ErrorCode::BadData, "a matte of another size than its tile"); };
  std::vector<std::uint8_t> bytes;
  bytes.reserve(size);
  for (std::size_t at = 0; at < code.size();) {
    const auto control = static_cast<std::uint8_t>(code[at++]);
    if (control < 0x80) {
      if (control > code.size() - at || control > size - bytes.size()) return bad();
      bytes.insert(bytes.end(), code.begin() + static_cast<std::ptrdiff_t>(at),
                   code.begin() + static_cast<std::ptrdiff_t>(at + control));
      at += control;
      continue;
    }
    std::size_t run = control & 0x3f;
    if ((control & 0x40) != 0) {
      if (at == code.size()) return bad();
      run = run << 8 | static_cast<std::uint8_t>(code[at++]);
    }
    if (at == code.size() || run > size - bytes.size()) return bad();
    bytes.insert(bytes.end(), run, static_cast<std::uint8_t>(code[at++]));
  }
  if (bytes.size() != size) return bad();
  return bytes;
}

}  // namespace floatstage::studio::wire
