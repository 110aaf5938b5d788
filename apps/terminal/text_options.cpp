#include "apps/terminal/text_options.h"

#include <charconv>
#include <optional>

#include "core/text.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::apps {
namespace {

std::optional<int> whole_number(std::string_view s) {
  int value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  if (error != std::errc() || end != s.data() + s.size()) return std::nullopt;
  return value;
}

std::vector<std::string> split(std::string_view s, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= s.size();) {
    const std::size_t end = std::min(s.find(separator, begin), s.size());
    parts.emplace_back(s.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

}  // namespace

Result<std::pair<int, int>> parse_size(std::string_view s) {
  constexpr int kLargest = 16384;
  const std::vector<std::string> parts = split(s, 'x');
  if (parts.size() == 2) {
    const std::optional<int> w = whole_number(parts[0]), h = whole_number(parts[1]);
    if (w && h && *w > 0 && *h > 0 && *w <= kLargest && *h <= kLargest) return std::pair(*w, *h);
  }
  return fail(ErrorCode::InvalidArgument, text("'", s, "' is not a size; write it as 640x480"));
}

std::vector<std::string> split_list(std::string_view s) {
  std::vector<std::string> parts = split(s, ',');
  std::erase_if(parts, [](const std::string& p) { return p.empty(); });
  return parts;
}

Result<std::vector<int>> parse_frames(std::string_view s, int count) {
  pipeline::FrameRange range;
  if (!s.empty()) {
    const Result<pipeline::FrameRange> parsed = pipeline::parse_frame_range(s);
    if (!parsed) return forward(parsed);
    range = *parsed;
  }
  const int end = range.end.value_or(count);
  if (end > count || range.first >= end)
    return fail(ErrorCode::InvalidArgument,
                text("frames '", s, "' are not all in the take, which has ", count));
  std::vector<int> frames;
  for (int f = range.first; f < end; f += range.step) frames.push_back(f);
  return frames;
}

Result<std::array<float, 3>> parse_color(std::string_view given) {
  if (given.size() != 6 || given.find_first_not_of("0123456789abcdefABCDEF") != given.npos)
    return fail(ErrorCode::InvalidArgument,
                text("--background '", given, "' is not a colour; write it as rrggbb"));
  std::array<float, 3> color{};
  for (std::size_t i = 0; i < color.size(); ++i)
    color[i] = static_cast<float>(std::stoi(std::string(given.substr(2 * i, 2)), nullptr, 16)) / 255.F;
  return color;
}

}  // namespace floatstage::apps
