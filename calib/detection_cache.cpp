#include "calib/detection_cache.h"

#include <charconv>
#include <cmath>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr int kVersion = 2;  // grows whenever detect() finds something else in the same picture

std::string exact(double value) {
  char digits[64];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string_view next_word(std::string_view& rest) {
  const std::size_t end = std::min(rest.find(' '), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return word;
}

template <class Number>
bool read(std::string_view word, Number& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

Result<std::string> content_key(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return content_hash(*bytes);
}

std::string to_text(const Detection& d) {
  std::string lines = text("floatstage-detection ", kVersion, "\n", name_of(d.failure), "\n", d.reason, "\n");
  for (const SeenPoint& p : d.points)
    lines += text(p.id, " ", exact(p.pixel.x()), " ", exact(p.pixel.y()), " ", exact(p.sigma), "\n");
  return lines + "end\n";
}

Result<Detection> parse_detection(std::string_view bytes, std::string_view name) {
  int number = 0;
  auto wrong = [&](const char* what) {
    return fail(ErrorCode::BadData, text(name, ": line ", number, ": ", what, "; delete the file"));
  };
  auto line = [&]() -> std::optional<std::string_view> {
    ++number;
    const std::size_t end = bytes.find('\n');
    if (end == bytes.npos) return std::nullopt;
    const std::string_view found = bytes.substr(0, end);
    bytes.remove_prefix(end + 1);
    return found;
  };
  Detection d;
  if (line() != text("floatstage-detection ", kVersion)) return wrong("not a detection of this version");
  const auto failure = line();
  const auto known = failure ? detection_failure_named(*failure) : std::nullopt;
  if (!known) return wrong("an unknown outcome");
  d.failure = *known;
  const auto reason = line();
  if (!reason) return wrong("the reason is missing");
  d.reason = *reason;
  for (auto next = line(); next != "end"; next = line()) {
    if (!next) return wrong("it is cut off");
    SeenPoint p;
    std::string_view rest = *next;
    if (!read(next_word(rest), p.id) || !read(next_word(rest), p.pixel.x()) ||
        !read(next_word(rest), p.pixel.y()) || !read(next_word(rest), p.sigma) || !rest.empty())
      return wrong("not a point");
    if (!p.pixel.allFinite() || !(p.sigma > 0) || !std::isfinite(p.sigma))
      return wrong("a number that is not finite");
    if (p.id < 0 || (!d.points.empty() && p.id <= d.points.back().id)) return wrong("ids do not ascend");
    d.points.push_back(p);
  }
  if (!bytes.empty()) return wrong("something follows the end");
  if ((d.failure == DetectionFailure::None) == d.points.empty())
    return wrong("points and outcome contradict each other");
  return d;
}

DetectionCache::DetectionCache(std::filesystem::path folder, const TargetDesign& design,
                               const DetectOptions& options)
    : folder_(std::move(folder)),
      about_(text(kVersion, ' ', to_text(design), ' ', options.least_points, ' ', options.diagnose, ' ',
                  exact(options.sigma))) {
  if (folder_.empty()) return;
  if (const Result<void> made = make_folder(folder_); !made) {
    log::warning(text(made.error().message, "; detections are not cached"));
    folder_.clear();
  }
}

std::filesystem::path DetectionCache::file(const std::string& key) const {
  return folder_ / (content_hash(about_ + '\n' + key) + ".detection");
}

std::optional<Detection> DetectionCache::find(const std::string& key) const {
  if (folder_.empty() || key.empty()) return std::nullopt;
  const std::filesystem::path name = file(key);
  if (!is_there(name)) return std::nullopt;
  const Result<std::string> bytes = read_file(name);
  if (!bytes) return std::nullopt;
  Result<Detection> detection = parse_detection(*bytes, name.string());
  if (!detection) return std::nullopt;  // damaged: found again and written anew
  return *std::move(detection);
}

void DetectionCache::store(const std::string& key, const Detection& detection) const {
  if (folder_.empty() || key.empty()) return;
  if (const Result<void> written = write_file(file(key), to_text(detection)); !written)
    log::debug(written.error().message);
}

}  // namespace floatstage::calib
