#include "calib/chessboard_grid.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace floatstage::calib {
namespace {

using Place = std::pair<int, int>;
constexpr std::array<Place, 4> kDirections = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

Place operator+(Place a, Place b) { return {a.first + b.first, a.second + b.second}; }
Place operator-(Place a, Place b) { return {a.first - b.first, a.second - b.second}; }

bool opposite(const Saddle& a, const Saddle& b) {
  const float dot = a.second.dot(b.second);
  return dot < -0.4f * static_cast<float>(cv::norm(a.second) * cv::norm(b.second));
}

class Growth {
 public:
  explicit Growth(const std::vector<Saddle>& saddles) : saddles_(saddles), used_(saddles.size(), false) {}

  // The grid that begins at this crossing; empty when it has no neighbour both ways.
  std::map<Place, std::size_t> from(std::size_t seed) {
    taken_.clear();
    std::fill(used_.begin(), used_.end(), false);
    take({0, 0}, seed);
    const Saddle& s = saddles_[seed];
    // Edges run half way between the light and the dark squares.
    const double light = std::atan2(s.second[1], s.second[0]) / 2;
    std::array<std::optional<cv::Point2f>, 2> step;
    for (int axis = 0; axis < 2; ++axis) {
      const double angle = light + std::numbers::pi / 4 + axis * std::numbers::pi / 2;
      const cv::Point2f way(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
      for (const float sign : {1.0f, -1.0f}) {
        const std::optional<std::size_t> next = nearest_along(seed, sign * way);
        if (!next) continue;
        const Place place = axis == 0 ? Place{sign > 0 ? 1 : -1, 0} : Place{0, sign > 0 ? 1 : -1};
        step[static_cast<std::size_t>(axis)] = sign * (saddles_[*next].at - s.at);
        take(place, *next);
        break;
      }
    }
    if (!step[0] || !step[1]) return {};
    first_step_ = {*step[0], *step[1]};
    for (bool grown = true; grown;) {
      grown = false;
      const std::map<Place, std::size_t> now = taken_;
      for (const auto& [place, index] : now)
        for (const Place& way : kDirections)
          if (!taken_.contains(place + way)) grown |= extend(place, way);
    }
    return taken_;
  }

 private:
  void take(Place place, std::size_t index) {
    taken_[place] = index;
    used_[index] = true;
  }

  std::optional<std::size_t> nearest_along(std::size_t from, cv::Point2f way) const {
    std::optional<std::size_t> best;
    float nearest = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < saddles_.size(); ++i) {
      if (used_[i] || !opposite(saddles_[from], saddles_[i])) continue;
      const cv::Point2f d = saddles_[i].at - saddles_[from].at;
      const float length = std::hypot(d.x, d.y);
      if (length >= nearest || d.dot(way) < 0.87f * length) continue;
      nearest = length;
      best = i;
    }
    return best;
  }

  const cv::Point2f* at(Place place) const {
    const auto found = taken_.find(place);
    return found == taken_.end() ? nullptr : &saddles_[found->second].at;
  }

  // Where the neighbour should be: on through the crossing behind, else beside a neighbour's step, else by
  // the first step. The second of the pair is the length of the step that the guess rests on.
  std::pair<cv::Point2f, float> expect(Place place, Place way) const {
    const cv::Point2f here = *at(place);
    cv::Point2f step;
    if (const cv::Point2f* behind = at(place - way)) {
      step = here - *behind;
      if (const cv::Point2f* further =
              at(place - way - way)) {  // steps shrink with distance: keep their ratio
        const cv::Point2f before = *behind - *further;
        const float ratio = std::hypot(step.x, step.y) / std::max(std::hypot(before.x, before.y), 1e-3f);
        step *= std::min(std::max(ratio, 0.75f), 1.33f);
      }
    } else {
      const Place side = {way.second, way.first};
      const cv::Point2f *a = at(place + side), *b = at(place + side + way), *c = at(place - side),
                        *d = at(place - side + way);
      if (a && b)
        step = *b - *a;
      else if (c && d)
        step = *d - *c;
      else
        step = first_step_[way.first == 0] * static_cast<float>(way.first + way.second);
    }
    return {here + step, std::hypot(step.x, step.y)};
  }

  bool extend(Place place, Place way) {
    const auto [where, step] = expect(place, way);
    if (!(step > 4)) return false;
    const Saddle& here = saddles_[taken_.at(place)];
    std::optional<std::size_t> best;
    float nearest = 0.3f * step;
    for (std::size_t i = 0; i < saddles_.size(); ++i) {
      if (used_[i]) continue;
      const cv::Point2f d = saddles_[i].at - where;
      const float off = std::hypot(d.x, d.y);
      if (off >= nearest || !opposite(here, saddles_[i])) continue;
      nearest = off;
      best = i;
    }
    if (!best) return false;
    take(place + way, *best);
    return true;
  }

  const std::vector<Saddle>& saddles_;
  std::vector<bool> used_;
  std::map<Place, std::size_t> taken_;
  std::array<cv::Point2f, 2> first_step_;
};

}  // namespace

ChessboardGrid grow_chessboard(const std::vector<Saddle>& saddles, std::size_t enough) {
  constexpr std::size_t kMostSeeds = 60;
  Growth growth(saddles);
  std::map<Place, std::size_t> largest;
  std::vector<bool> tried(saddles.size(),
                          false);  // what lies in a grid that was grown already grows the same one
  std::size_t seeds = 0;
  for (std::size_t seed = 0; seed < saddles.size() && seeds < kMostSeeds; ++seed) {
    if (tried[seed]) continue;
    ++seeds;
    std::map<Place, std::size_t> grid = growth.from(seed);
    if (grid.size() >= 6)
      for (const auto& [place, index] : grid) tried[index] = true;
    if (grid.size() > largest.size()) largest = std::move(grid);
    if (largest.size() >= enough) break;
  }
  ChessboardGrid result;
  if (largest.size() < 4) return result;
  Place low = largest.begin()->first, high = low;
  for (const auto& [place, index] : largest) {
    low = {std::min(low.first, place.first), std::min(low.second, place.second)};
    high = {std::max(high.first, place.first), std::max(high.second, place.second)};
  }
  result.columns = high.first - low.first + 1;
  result.rows = high.second - low.second + 1;
  for (const auto& [place, index] : largest) result.corners[place - low] = saddles[index].at;
  return result;
}

}  // namespace floatstage::calib
