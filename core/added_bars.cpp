// Method:  lines of one colour at the sides, told from the stage by the step behind them
// ADR:     0206

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include "core/added_search.h"
#include "core/statistics.h"

namespace floatstage {
namespace {

constexpr int kEven = 4;           // 8-bit steps that codecs leave of one colour, up and down
constexpr int kMostShare = 4;      // a quarter of the picture a side
constexpr int kRinging = 8;        // px: as far as a block of a codec carries what is beyond the edge
constexpr int kBlurred = 12;       // 8-bit steps of an edge that leaves ripples
constexpr int kOverexposed = 250;  // 8-bit
constexpr int kTinted = 16;        // 8-bit steps between channels: more than a codec does to grey
constexpr double kEnds = 0.75;     // of it ends within three lines, where it is not even to its end
constexpr double kWritten = 0.25;  // of a line may be text, where the rest is of one colour exactly

// The lines of one side, from the outside in, over all pictures.
class Side {
 public:
  Side(std::span<const Image* const> pictures, bool columns, bool from_end)
      : pictures_(pictures), columns_(columns), from_end_(from_end) {
    for (std::size_t c = 0; c < colour_.size(); ++c) {
      std::vector<int> values;
      for (const Image* p : pictures_)
        for (int i = 0; i < length(); ++i) values.push_back(at(*p, 0, i)[c]);
      colour_[c] = median(std::move(values));
    }
  }

  int added() const {
    const int most = lines() / kMostShare;
    int even = 0;
    while (even <= most && is_even(even)) ++even;
    if (even == 0 || even > most || is_sky() || is_reached_into(even)) return 0;
    int first = even;
    while (first < even + kRinging && first < lines() && share_ended(even - 1, first, kEven) < 0.5) ++first;
    if (first == even + kRinging || first + 1 >= lines()) return 0;
    if (first == even && share_off(even - 1, kEven) == 0) return first;
    // Written on, or a codec blurred the edge, and the first line is half of each. Else it is a shade that
    // grows, or hedges before an even sky, which end line by line.
    if (share_ended(std::max(even - 1, first - 2), first + 1, kBlurred) < kEnds) return 0;
    return first == even ? first : first + 1;
  }

 private:
  int lines() const { return columns_ ? pictures_[0]->width : pictures_[0]->height; }
  int length() const { return columns_ ? pictures_[0]->height : pictures_[0]->width; }
  const std::uint8_t* at(const Image& p, int line, int i) const {
    const int l = from_end_ ? lines() - 1 - line : line;
    return columns_ ? p.at(l, i) : p.at(i, l);
  }
  bool off(const Image& p, int line, int i, int steps) const {
    const std::uint8_t* pixel = at(p, line, i);
    for (std::size_t c = 0; c < colour_.size(); ++c)
      if (std::abs(pixel[c] - colour_[c]) > steps) return true;
    return false;
  }
  // Share of a line's pixels, over all pictures, that are off the colour of the outermost line.
  double share_off(int line, int steps) const {
    int count = 0;
    for (const Image* p : pictures_)
      for (int i = 0; i < length(); ++i) count += off(*p, line, i, steps);
    return count / (static_cast<double>(length()) * static_cast<double>(pictures_.size()));
  }
  // Of what has the outermost line's colour in one line, the share that is off it in another: writing that
  // crosses a bar's edge does not count.
  double share_ended(int line, int other, int steps) const {
    int lasted = 0, ended = 0;
    for (const Image* p : pictures_)
      for (int i = 0; i < length(); ++i) {
        if (off(*p, line, i, steps)) continue;
        ++lasted;
        ended += off(*p, other, i, steps);
      }
    return lasted > 0 ? static_cast<double>(ended) / lasted : 0;
  }
  // Bars are grey. What is even because it is overexposed, or tinted, is the scene's.
  bool is_sky() const {
    const auto [least, most] = std::minmax_element(colour_.begin(), colour_.end());
    return *least >= kOverexposed || *most - *least > kTinted;
  }
  // Whether something goes on from the picture into so many lines, deeper and wider than a codec's ringing
  // and than strokes of text: a head before an overexposed sky.
  bool is_reached_into(int lines) const {
    if (lines <= kRinging) return false;
    for (const Image* p : pictures_)
      for (int i = 0, wide = 0; i < length(); ++i) {
        int deep = 0;
        while (deep <= kRinging && off(*p, lines - 1 - deep, i, kBlurred)) ++deep;
        wide = deep > kRinging ? wide + 1 : 0;
        if (wide > kRinging) return true;
      }
    return false;
  }
  bool is_even(int line) const { return share_off(line, kEven) == 0 || share_off(line, 1) < kWritten; }

  std::span<const Image* const> pictures_;
  bool columns_, from_end_;
  std::array<int, 3> colour_{};
};

}  // namespace

AddedContent added_bars(std::span<const Image> pictures) {
  std::vector<const Image*> same;
  for (const Image& p : pictures)
    if (!p.empty() && p.channels == 3 && p.width == pictures[0].width && p.height == pictures[0].height)
      same.push_back(&p);
  if (same.empty()) return {};
  AddedContent added;
  added.left = Side(same, true, false).added();
  added.top = Side(same, false, false).added();
  added.right = Side(same, true, true).added();
  added.bottom = Side(same, false, true).added();
  return added;
}

}  // namespace floatstage
