#include "studio/live/live_quality.h"

#include <algorithm>

#include "core/text.h"

namespace floatstage::studio {
namespace {

constexpr double kSlow = 0.97;   // of the target: below it a window is too slow
constexpr int kSlowWindows = 2;  // in a row
constexpr double kRoom = 1.3;    // times the target: there is room for a better quality
constexpr double kEasy = 0.6;    // of the time at work, when every instant is shown: there is room too
constexpr double kLongestPatience = 120;

render::FlowOptions flow(const char* preset, int shrink, int refinement) {
  render::FlowOptions options;
  options.preset = preset;
  options.shrink = shrink;
  options.refinement = refinement;
  return options;
}

}  // namespace

const std::vector<LiveQuality>& live_qualities() {
  static const std::vector<LiveQuality> ladder = {
      {"best", {.shrink = 2, .tolerance = 0.5}, "floating", flow("medium", 1, 20), true},
      {"good", {.shrink = 2, .tolerance = 0.5}, "floating", flow("medium", 2, 5), true},
      {"fair", {.shrink = 3, .tolerance = 1}, "floating", flow("fast", 2, 2), true},
      {"fast", {.shrink = 4, .tolerance = 1}, "floating", flow("ultrafast", 2, 0), false},
      {"faster", {.shrink = 4, .tolerance = 1.5}, "floating", flow("ultrafast", 4, 0), false},
      {"plain", {.shrink = 4, .tolerance = 1.5}, "linear", flow("ultrafast", 4, 0), false},
  };
  return ladder;
}

std::string describe(const LiveQuality& q) {
  std::string line =
      text(q.name, ": keys at 1/", q.node.shrink, ", outlines within ", q.node.tolerance, " px, ", q.method);
  if (q.method == "floating")
    line +=
        text(", ", q.flow.preset, " flow at 1/", q.flow.shrink, " with ", q.flow.refinement, " refinements");
  if (!q.sharp) line += ", bilinear";
  return line;
}

std::optional<std::size_t> QualityControl::judge(Timestamp time, double fps, double offered, double busy) {
  if (target_ <= 0 || offered <= 0) return std::nullopt;  // where nothing comes, nothing can be said
  const double wanted = std::min(target_, offered);
  if (fps < kSlow * wanted) {
    easy_since_.reset();
    if (++slow_ < kSlowWindows || level_ + 1 >= live_qualities().size()) return std::nullopt;
    slow_ = 0;
    // A better quality that did not last is tried less often.
    if (rose_ && seconds(time - *rose_) < patience_s_)
      patience_s_ = std::min(2 * patience_s_, kLongestPatience);
    return ++level_;
  }
  slow_ = 0;
  const bool room = fps >= kRoom * wanted || (fps >= kSlow * offered && busy < kEasy);
  if (!room || level_ == 0) {
    easy_since_.reset();
    return std::nullopt;
  }
  if (!easy_since_) easy_since_ = time;
  if (seconds(time - *easy_since_) < patience_s_) return std::nullopt;
  easy_since_.reset();
  rose_ = time;
  return --level_;
}

}  // namespace floatstage::studio
