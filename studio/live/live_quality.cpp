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

render::FlowOptions flow(int warps, int finest_scale) {
  render::FlowOptions options;
  options.preset = "fast";
  options.iterations = warps;
  options.finest_scale = finest_scale;
  return options;
}

}  // namespace

const std::vector<LiveQuality>& live_qualities() {
  static const std::vector<LiveQuality> ladder = {
      {"best", {.shrink = 1, .tolerance = 0.75}, "floating", flow(2, 0), true, 1},
      {"good", {.shrink = 1, .tolerance = 0.75}, "floating", flow(1, 0), true, 1},
      {"fair", {.shrink = 1, .tolerance = 0.75}, "floating", flow(1, 1), true, 1},
      {"fast", {.shrink = 1, .tolerance = 1.5}, "floating", flow(1, 1), true, 1},
      {"faster", {.shrink = 2, .tolerance = 1.5}, "floating", flow(1, 1), true, 2},
      {"plain", {.shrink = 2, .tolerance = 1.5}, "linear", flow(1, 1), false, 1},
  };
  return ladder;
}

std::string describe(const LiveQuality& q) {
  std::string line =
      text(q.name, ": keys at 1/", q.node.shrink, ", outlines within ", q.node.tolerance, " px, ", q.method);
  if (q.method == "floating")
    line += text(", flow at 1/", 1 << q.flow.finest_scale, " with ", q.flow.iterations,
                 q.flow.iterations == 1 ? " warp" : " warps");
  if (q.output > 1) line += text(", drawn at 1/", q.output);
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
