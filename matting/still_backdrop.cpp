// Method:  what a still camera's pixel tells of what stands before it
// Differs: a change of light alone is told twice, as the stage's and as the subject's; who is right is for
//          several cameras to say
// ADR:     0301, 0326, 0351

#include "matting/still_backdrop.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"
#include "core/statistics.h"

namespace floatstage::matting {
namespace {

constexpr double kStillNoise = 2;        // 8-bit steps a channel: a place is no quieter than that
constexpr double kSomethingElse = 0.05;  // density of what stands before a place, against a colour's spread
constexpr double kSpread = 25;           // 8-bit steps, of colours at large
constexpr float kNeverChanged = 1.5f, kMostStill = 3;  // log-odds
constexpr int kChange = 20;                            // 8-bit steps a channel that are no noise
constexpr double kCalmPixels = 0.8;                    // share of a picture that shows no subject
constexpr double kLeastShared = 0.7;                   // 8-bit steps a channel, of a mean of nine pixels
constexpr int kBlocks = 24;                            // along a picture's longer side
constexpr double kDrifts = 5;      // what light that changes everywhere changes in places, of its median
constexpr double kOfShared = 0.3;  // of a change that nine pixels share: less has only a neighbour of it

std::size_t pixels(const Image& picture) {
  return static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

const std::uint8_t* colour(const Image& picture, std::size_t p) { return picture.pixels.data() + 3 * p; }

float squared(const std::uint8_t* a, const std::uint8_t* b) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) sum += static_cast<float>((a[c] - b[c]) * (a[c] - b[c]));
  return sum;
}

bool is_light(std::uint8_t plate_class) {
  return plate_class == static_cast<std::uint8_t>(PlateClass::Shadow) ||
         plate_class == static_cast<std::uint8_t>(PlateClass::Reflex);
}

// A pixel that shows a little of the subject is unlike the empty stage, too: at the rim only colours tell.
std::vector<float> without_rim(const std::vector<float>& odds, int w, int h) {
  std::vector<float> inner = odds;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float& here = inner[static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x)];
      if (here <= 0) continue;
      for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
        const int u = std::clamp(x + dx, 0, w - 1), v = std::clamp(y + dy, 0, h - 1);
        here = std::min(here,
                        std::max(0.0f, odds[static_cast<std::size_t>(v) * w + static_cast<std::size_t>(u)]));
      }
    }
  return inner;
}

using Change = std::array<int, 3>;

std::vector<Change> changes(const Image& picture, const Image& stage) {
  std::vector<Change> change(pixels(picture));
  for (std::size_t p = 0; p < change.size(); ++p)
    for (std::size_t c = 0; c < 3; ++c) change[p][c] = colour(picture, p)[c] - colour(stage, p)[c];
  return change;
}

// Of each pixel the mean square of a channel of the change that it shares with those around it; 0 where it
// has too little of it itself.
std::vector<float> shared_changes(const std::vector<Change>& change, int w, int h) {
  std::vector<float> shared(change.size());
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      Change sum{};
      int count = 0;
      for (int v = std::max(0, y - 1); v <= std::min(h - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(w - 1, x + 1); ++u, ++count)
          for (std::size_t c = 0; c < 3; ++c) sum[c] += change[static_cast<std::size_t>(v * w + u)][c];
      const auto p = static_cast<std::size_t>(y * w + x);
      double square = 0, own = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double mean = static_cast<double>(sum[c]) / count;
        square += mean * mean;
        own += mean * change[p][c];
      }
      if (own >= kOfShared * square) shared[p] = static_cast<float>(square / 3);
    }
  return shared;
}

// How much the light of the whole stage has changed: the median root mean square of a channel of what blocks,
// which noise leaves alone, have changed.
double drift_of(const std::vector<Change>& change, int w, int h) {
  const int side = std::max(2, std::max(w, h) / kBlocks);
  std::vector<double> squares;
  for (int y = 0; y + side <= h; y += side)
    for (int x = 0; x + side <= w; x += side) {
      Change sum{};
      for (int v = y; v < y + side; ++v)
        for (int u = x; u < x + side; ++u)
          for (std::size_t c = 0; c < 3; ++c) sum[c] += change[static_cast<std::size_t>(v * w + u)][c];
      double square = 0;
      for (const int of_channel : sum) square += static_cast<double>(of_channel) * of_channel;
      squares.push_back(square / 3 / (static_cast<double>(side) * side * side * side));
    }
  return squares.empty() ? 0 : std::sqrt(median(std::move(squares)));
}

// What changes all over a picture, by noise and by light: the root mean square of a channel.
double usual_of(std::vector<float> squares) {
  const auto at =
      squares.begin() + static_cast<std::ptrdiff_t>(kCalmPixels * static_cast<double>(squares.size() - 1));
  std::nth_element(squares.begin(), at, squares.end());
  return std::max(kLeastShared, std::sqrt(static_cast<double>(*at)));
}

}  // namespace

Result<StillBackdrop> StillBackdrop::learn(std::span<const Image> pictures, std::span<const Image> subjects) {
  if (pictures.size() < 2)
    return fail(ErrorCode::InvalidArgument, "a backdrop is learnt from two pictures or more");
  Result<Plate> plate =
      learn_plate({pictures.begin(), pictures.end()}, {}, {subjects.begin(), subjects.end()});
  if (!plate) return forward(plate);
  StillBackdrop out;
  out.changed_.assign(pixels(plate->color), 0);
  out.seen_.assign(out.changed_.size(), subjects.empty());
  for (const Image& subject : subjects)
    for (std::size_t p = 0; p < out.seen_.size(); ++p) out.seen_[p] |= subject.pixels[p] == 0;
  for (const Image& picture : pictures)
    for (std::size_t p = 0; p < out.changed_.size(); ++p)
      for (int c = 0; c < 3; ++c)
        if (std::abs(colour(picture, p)[c] - colour(plate->color, p)[c]) > kChange) out.changed_[p] = 1;
  out.plate_ = std::move(*plate);
  return out;
}

Result<StillBackdrop> StillBackdrop::of_empty_stage(const std::vector<Image>& photographs) {
  Result<Plate> plate = learn_plate(photographs);
  if (!plate) return forward(plate);
  StillBackdrop out;
  out.seen_.assign(pixels(plate->color), 1);
  out.changed_ = out.seen_;
  out.plate_ = std::move(*plate);
  out.empty_stage_ = true;
  return out;
}

// Of a pixel that is so many deviations from what is seen there when the subject is elsewhere.
float StillBackdrop::odds_of(std::size_t p, double squared_deviations, double sigma) const {
  const double here =
      plate_.confidence.pixels[p] / 255.0 * std::exp(-0.5 * squared_deviations) * kSpread / sigma +
      kSomethingElse;
  return std::clamp(static_cast<float>(-std::log(here)), changed_[p] ? -kMostStill : -kNeverChanged,
                    kMostStill);
}

std::vector<float> StillBackdrop::amid(std::vector<float> odds, const Image& picture,
                                       const Image& unlike) const {
  FLOATSTAGE_CHECK(unlike.empty() || unlike.pixels.size() == odds.size(), "what is unlike is of its size");
  std::vector<float> inner = without_rim(odds, picture.width, picture.height);
  for (std::size_t p = 0; p < unlike.pixels.size(); ++p)
    if (unlike.pixels[p]) inner[p] = odds[p];
  return inner;
}

std::vector<float> StillBackdrop::odds(const Image& picture, const Image& unlike) const {
  FLOATSTAGE_CHECK(picture.width == plate_.color.width && picture.height == plate_.color.height,
                   "a picture of its size");
  std::vector<float> odds(changed_.size());
  const Image classes = empty_stage_ ? classify(plate_, picture) : Image();
  for (std::size_t p = 0; p < odds.size(); ++p) {
    if (!knows(p)) continue;
    const double sigma = std::max(kStillNoise, plate_.noise.pixels[p] / 16.0);
    odds[p] = odds_of(p, squared(colour(picture, p), colour(plate_.color, p)) / (3 * sigma * sigma), sigma);
    if (empty_stage_ && is_light(classes.pixels[p])) odds[p] = std::min(odds[p], 0.0f);
  }
  return empty_stage_ ? amid(std::move(odds), picture, unlike) : odds;
}

std::vector<float> StillBackdrop::odds_in_constant_light(const Image& picture, const Image& unlike) const {
  if (!empty_stage_) return {};
  FLOATSTAGE_CHECK(picture.width == plate_.color.width && picture.height == plate_.color.height,
                   "a picture of its size");
  const std::vector<Change> change = changes(picture, plate_.color);
  const double drift = kDrifts * drift_of(change, picture.width, picture.height);
  if (drift > kSpread) return {};
  const std::vector<float> shared = shared_changes(change, picture.width, picture.height);
  const double usual = std::max(usual_of(shared), drift);
  std::vector<float> odds(changed_.size());
  for (std::size_t p = 0; p < odds.size(); ++p) {
    double sigma = std::max({kStillNoise, plate_.noise.pixels[p] / 16.0, drift});
    double z = squared(colour(picture, p), colour(plate_.color, p)) / (3 * sigma * sigma);
    if (const double by_all = shared[p] / (usual * usual); by_all > z) z = by_all, sigma = usual;
    odds[p] = odds_of(p, z, sigma);
  }
  return amid(std::move(odds), picture, unlike);
}

}  // namespace floatstage::matting
