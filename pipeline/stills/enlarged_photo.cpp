#include "pipeline/stills/enlarged_photo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "core/parallel.h"
#include "core/statistics.h"
#include "pipeline/bicubic.h"
#include "pipeline/enlarged_box.h"
#include "render/flow.h"

namespace floatstage::pipeline {
namespace {

constexpr std::uint8_t kSubject = 128;
constexpr int kMargin = 4;       // px around what a still shows, for the flow
constexpr int kLeastSide = 24;   // px of a photograph that a still must cover to be bent to it
constexpr int kRounds = 2;       // of bending
constexpr float kRoundTrip = 1;  // px by which the flow there and back may miss
constexpr int kNear = 2;         // px to each side: the neighbourhood that is compared
// Share of a neighbourhood's contrast that the still leaves unexplained: up to which it is believed whole,
// and from which on not at all.
constexpr float kExplained = 0.15F, kUnexplained = 0.5F;
constexpr float kNoise = 3;  // 8-bit steps: contrast below which there is nothing to compare
constexpr double kLeastGain = 0.4, kMostGain = 2.5;  // of contrast, between two cameras
// Details are carried where the same, an octave coarser, would have brought the photograph at half its size
// nearer to itself: the part of what they add there that is true, below which none is added, and from which
// on all. Over neighbourhoods of so many px each way.
constexpr float kUntrue = 0.3F, kTrue = 0.7F;
constexpr int kProven = 8;
// The calmest share of what a still shows finer than the photograph is taken for its noise.
constexpr double kCalm = 0.1;
constexpr double kLeastUsed = 1e-4;  // of the subject

const Eigen::Vector2f kNowhere(std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::quiet_NaN());

bool is_there(const Eigen::Vector2f& place) { return std::isfinite(place.x()) && std::isfinite(place.y()); }

// The mean of n x n pixels each.
Image shrunk_by(const Image& picture, int n) {
  if (n <= 1) return picture;
  Image small(std::max(1, picture.width / n), std::max(1, picture.height / n), picture.channels);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int k = 0; k < small.channels; ++k) {
        int sum = 0, count = 0;
        for (int j = y * n; j < std::min(picture.height, (y + 1) * n); ++j)
          for (int i = x * n; i < std::min(picture.width, (x + 1) * n); ++i, ++count)
            sum += picture.at(i, j)[k];
        small.at(x, y)[k] = static_cast<std::uint8_t>((sum + count / 2) / count);
      }
  return small;
}

std::uint8_t rounded(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

float smooth_step(float from, float to, float value) {
  const float t = std::clamp((value - from) / (to - from), 0.F, 1.F);
  return t * t * (3 - 2 * t);
}

}  // namespace

StillMap::StillMap(int w, int h) : width(w), height(h), at(static_cast<std::size_t>(w) * h, kNowhere) {}

Eigen::Vector2f StillMap::between(double x, double y) const {
  const int x0 = static_cast<int>(std::floor(x - 0.5)), y0 = static_cast<int>(std::floor(y - 0.5));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= width || y0 + 1 >= height) return kNowhere;
  const auto fx = static_cast<float>(x - 0.5 - x0), fy = static_cast<float>(y - 0.5 - y0);
  const StillMap& m = *this;
  return (m(x0, y0) * (1 - fx) + m(x0 + 1, y0) * fx) * (1 - fy) +
         (m(x0, y0 + 1) * (1 - fx) + m(x0 + 1, y0 + 1) * fx) * fy;
}

namespace {

// Halves of a picture and of a map, for the rehearsal at half size.
StillMap halved(const StillMap& map) {
  StillMap half(map.width / 2, map.height / 2);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      half(x, y) =
          (map(2 * x, 2 * y) + map(2 * x + 1, 2 * y) + map(2 * x, 2 * y + 1) + map(2 * x + 1, 2 * y + 1)) / 4;
  return half;
}

}  // namespace

// A still as the photograph's camera would see it, over a box of the photograph's pixels.
struct EnlargedPhoto::Fine {
  EnlargedBox box;
  std::vector<std::array<float, 3>> pixels;                    // scale times as fine as the photograph
  std::vector<std::array<float, 3>> means;                     // over each of the photograph's pixels
  std::vector<std::uint8_t> known;                             // by the photograph's pixel
  std::array<double, 3> gain = {1, 1, 1}, offset = {0, 0, 0};  // to the photograph's tones

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * box.width + x; }
  float toned(std::size_t pixel, std::size_t k) const {
    return static_cast<float>(gain[k] * means[pixel][k] + offset[k]);
  }
};

EnlargedPhoto::EnlargedPhoto(const Image& picture, const Image& matte, int scale, int threads)
    : photo_(picture),
      matte_(matte),
      scale_(scale),
      threads_(threads),
      enlarged_(enlarged_picture(picture, scale, threads)),
      provenance_(picture.width * scale, picture.height * scale, 1) {}

bool EnlargedPhoto::is_subject(int x, int y) const { return matte_.empty() || *matte_.at(x, y) >= kSubject; }

EnlargedBox EnlargedPhoto::box_of(const StillMap& map) const {
  int left = map.width, top = map.height, right = 0, bottom = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      if (is_there(map(x, y)) && is_subject(x, y)) {
        left = std::min(left, x), right = std::max(right, x + 1);
        top = std::min(top, y), bottom = std::max(bottom, y + 1);
      }
  if (right <= left) return {};
  left = std::max(0, left - kMargin), top = std::max(0, top - kMargin);
  right = std::min(map.width, right + kMargin), bottom = std::min(map.height, bottom + kMargin);
  return {left, top, right - left, bottom - top};
}

EnlargedPhoto::Fine EnlargedPhoto::seen_through(const Image& still, const StillMap& map,
                                                const EnlargedBox& box, int shrunk) const {
  Fine fine;
  fine.box = box;
  const int width = box.width * scale_;
  fine.pixels.resize(static_cast<std::size_t>(width) * box.height * scale_);
  fine.means.resize(static_cast<std::size_t>(box.width) * box.height);
  fine.known.resize(fine.means.size());
  parallel_for(static_cast<std::size_t>(box.height), threads_, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < box.width; ++x) {
      std::array<float, 3> sum{};
      bool known = true;
      for (int j = 0; j < scale_ && known; ++j)
        for (int i = 0; i < scale_; ++i) {
          const Eigen::Vector2f place =
              map.between(box.x + x + (i + 0.5) / scale_, box.y + y + (j + 0.5) / scale_);
          if (!(known = is_there(place))) break;
          auto& pixel = fine.pixels[static_cast<std::size_t>(y * scale_ + j) * width + x * scale_ + i];
          for (int k = 0; k < 3; ++k) {
            const auto at = static_cast<std::size_t>(k);
            pixel[at] = static_cast<float>(read_bicubic(still, place.x() / shrunk, place.y() / shrunk, k));
            sum[at] += pixel[at];
          }
        }
      const std::size_t index = fine.index(x, y);
      fine.known[index] = known ? 1 : 0;
      // Where nothing is known the photograph stands in, so that what lies beside it is read undisturbed.
      for (std::size_t k = 0; k < 3; ++k)
        fine.means[index][k] = known ? sum[k] / static_cast<float>(scale_ * scale_)
                                     : static_cast<float>(photo_.at(box.x + x, box.y + y)[k]);
    }
  });
  return fine;
}

// Each channel by a line, fitted twice: the second time to what the first one explains.
void EnlargedPhoto::match_tones(Fine& fine, const EnlargedBox& box) const {
  for (std::size_t k = 0; k < 3; ++k) {
    double spread = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 2; ++round) {
      double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, apart = 0;
      const auto each = [&](const auto& visit) {
        for (int y = 0; y < box.height; ++y)
          for (int x = 0; x < box.width; ++x) {
            if (fine.known[fine.index(x, y)] == 0 || !is_subject(box.x + x, box.y + y)) continue;
            const double s = fine.means[fine.index(x, y)][k], p = photo_.at(box.x + x, box.y + y)[k];
            if (std::abs(fine.gain[k] * s + fine.offset[k] - p) <= spread) visit(s, p);
          }
      };
      each([&](double s, double p) { n += 1, sx += s, sy += p, sxx += s * s, sxy += s * p; });
      const double variance = n * sxx - sx * sx;
      if (n < 2 || variance <= 0) break;
      const double gain = std::clamp((n * sxy - sx * sy) / variance, kLeastGain, kMostGain);
      const double offset = (sy - gain * sx) / n;
      fine.gain[k] = gain, fine.offset[k] = offset;
      spread = std::numeric_limits<double>::infinity();
      each([&](double s, double p) { apart += (gain * s + offset - p) * (gain * s + offset - p); });
      spread = 2 * std::sqrt(apart / n) + 1;
    }
  }
}

// The still's place in each pixel moves along the flow from the photograph to the still as it is seen now.
Result<void> EnlargedPhoto::bend(const Fine& fine, const EnlargedBox& box, StillMap& map) const {
  const std::size_t count = fine.means.size();
  std::vector<std::uint8_t> gray[2], state(count);
  for (auto& plane : gray) plane.resize(count);
  const auto brightness = [](double r, double g, double b) {
    return rounded(0.299 * r + 0.587 * g + 0.114 * b);
  };
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const std::size_t i = fine.index(x, y);
      const std::uint8_t* photo = photo_.at(box.x + x, box.y + y);
      gray[0][i] = brightness(photo[0], photo[1], photo[2]);
      const bool known = fine.known[i] != 0;
      gray[1][i] = known ? brightness(fine.toned(i, 0), fine.toned(i, 1), fine.toned(i, 2)) : gray[0][i];
      state[i] = known && is_subject(box.x + x, box.y + y) ? 255 : 0;
    }
  render::FlowOptions options;
  options.preset = "quality";
  Result<std::unique_ptr<render::FlowEstimator>> estimator = render::make_flow_estimator(options);
  if (!estimator) return forward(estimator);
  const render::FlowImage images[2] = {{box.width, box.height, gray[0].data(), state.data()},
                                       {box.width, box.height, gray[1].data(), state.data()}};
  const render::FlowPair pairs[2] = {{0, 1}, {1, 0}};
  render::FlowField fields[2];
  if (Result<void> ok = (*estimator)->estimate(images, pairs, {}, threads_, fields); !ok) return ok;
  const StillMap before = map;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const std::size_t i = fine.index(x, y);
      Eigen::Vector2f& place = map(box.x + x, box.y + y);
      if (fine.known[i] == 0) continue;
      const float u = fields[0].uv[2 * i], v = fields[0].uv[2 * i + 1];
      const int tx = std::clamp(static_cast<int>(std::lround(x + u)), 0, box.width - 1),
                ty = std::clamp(static_cast<int>(std::lround(y + v)), 0, box.height - 1);
      const std::size_t t = fine.index(tx, ty);
      const float home = std::hypot(u + fields[1].uv[2 * t], v + fields[1].uv[2 * t + 1]);
      place = home <= kRoundTrip ? before.between(box.x + x + 0.5 + static_cast<double>(u),
                                                  box.y + y + 0.5 + static_cast<double>(v))
                                 : kNowhere;
    }
  return {};
}

// 0 … 1 by the photograph's pixel: how far the still explains the finest that the photograph shows around it,
// which is what tells best whether it lies there to a fraction of a pixel; fading towards what it does not.
std::vector<float> EnlargedPhoto::trust(const Fine& fine, const EnlargedBox& box) const {
  std::vector<float> explained(fine.means.size(), 0.F), least(explained.size()), out(explained.size());
  const auto usable = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < box.width && y < box.height && fine.known[fine.index(x, y)] != 0 &&
           is_subject(box.x + x, box.y + y);
  };
  // By how much a pixel stands out of those around it, in the photograph and in what the still leaves of it.
  std::vector<std::array<float, 3>> shown(explained.size()), left(explained.size());
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      if (!usable(x, y)) continue;
      const std::size_t here = fine.index(x, y);
      float n = 0;
      std::array<float, 3> photo{}, still{};
      for (int j = y - 1; j <= y + 1; ++j)
        for (int i = x - 1; i <= x + 1; ++i) {
          if (!usable(i, j)) continue;
          n += 1;
          for (std::size_t k = 0; k < 3; ++k)
            photo[k] += photo_.at(box.x + i, box.y + j)[k], still[k] += fine.toned(fine.index(i, j), k);
        }
      for (std::size_t k = 0; k < 3; ++k) {
        shown[here][k] = static_cast<float>(photo_.at(box.x + x, box.y + y)[k]) - photo[k] / n;
        left[here][k] = shown[here][k] - (fine.toned(here, k) - still[k] / n);
      }
    }
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      if (!usable(x, y)) continue;
      float apart = 0, contrast = 0;
      for (int j = y - kNear; j <= y + kNear; ++j)
        for (int i = x - kNear; i <= x + kNear; ++i) {
          if (!usable(i, j)) continue;
          for (std::size_t k = 0; k < 3; ++k) {
            const float s = shown[fine.index(i, j)][k], l = left[fine.index(i, j)][k];
            contrast += s * s + kNoise * kNoise, apart += l * l;
          }
        }
      explained[fine.index(x, y)] = 1 - smooth_step(kExplained, kUnexplained, apart / contrast);
    }
  const auto filtered = [&](const std::vector<float>& from, std::vector<float>& to, const auto& value) {
    for (int y = 0; y < box.height; ++y)
      for (int x = 0; x < box.width; ++x) {
        std::array<float, 9> around{};
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i)
            if (x + i >= 0 && y + j >= 0 && x + i < box.width && y + j < box.height)
              around[static_cast<std::size_t>(3 * (j + 1) + i + 1)] = from[fine.index(x + i, y + j)];
        to[fine.index(x, y)] = value(around);
      }
  };
  const auto minimum = [](const auto& a) { return *std::min_element(a.begin(), a.end()); };
  const auto mean = [](const auto& a) {
    float total = 0;
    for (const float value : a) total += value;
    return total / static_cast<float>(a.size());
  };
  filtered(explained, least, minimum);
  filtered(least, out, mean);
  return out;
}

// Details that are no stronger than the still's noise are its noise: of each neighbourhood's power the share
// that is more (Wiener's filter, by neighbourhood).
void EnlargedPhoto::take_noise_off(const Fine& fine, const std::vector<float>& coarse, const EnlargedBox& box,
                                   std::vector<float>& trusted) const {
  const std::size_t width = static_cast<std::size_t>(box.width) * scale_;
  std::vector<float> power(trusted.size(), 0.F), around(trusted.size(), 0.F), calm;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const std::size_t here = fine.index(x, y);
      if (fine.known[here] == 0) continue;
      for (int j = 0; j < scale_; ++j)
        for (int i = 0; i < scale_; ++i) {
          const std::size_t at =
              static_cast<std::size_t>(y * scale_ + j) * width + static_cast<std::size_t>(x * scale_ + i);
          for (std::size_t k = 0; k < 3; ++k) {
            const float d = fine.pixels[at][k] - coarse[3 * at + k];
            power[here] += d * d;
          }
        }
    }
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      float n = 0, sum = 0;
      for (int j = std::max(0, y - 1); j <= std::min(box.height - 1, y + 1); ++j)
        for (int i = std::max(0, x - 1); i <= std::min(box.width - 1, x + 1); ++i)
          if (fine.known[fine.index(i, j)] != 0) n += 1, sum += power[fine.index(i, j)];
      const std::size_t here = fine.index(x, y);
      around[here] = n > 0 ? sum / n : 0;
      if (trusted[here] > 0) calm.push_back(around[here]);
    }
  if (calm.empty()) return;
  const float noise = percentile_in_place(std::span<float>(calm), kCalm);
  for (std::size_t i = 0; i < trusted.size(); ++i)
    trusted[i] *= around[i] > noise ? 1 - noise / around[i] : 0;
}

void EnlargedPhoto::add(const Fine& fine, const EnlargedBox& box, const std::vector<float>& trusted,
                        detail::Provenance as) {
  const int width = box.width * scale_;
  const EnlargedBox whole{0, 0, box.width, box.height};
  const std::vector<float> photo = enlarged_box([&](int px, int py, int k) { return photo_.at(px, py)[k]; },
                                                photo_.width, photo_.height, box, 3, scale_, threads_);
  const std::vector<float> coarse = enlarged_box(
      [&](int px, int py, int k) { return fine.means[fine.index(px, py)][static_cast<std::size_t>(k)]; },
      box.width, box.height, whole, 3, scale_, threads_);
  std::vector<float> signal = trusted;
  take_noise_off(fine, coarse, box, signal);
  const auto opacity = [&](double x, double y) {  // of the box's pixels, between four
    const int x0 = std::clamp(static_cast<int>(std::floor(x - 0.5)), 0, box.width - 1),
              y0 = std::clamp(static_cast<int>(std::floor(y - 0.5)), 0, box.height - 1);
    const int x1 = std::min(x0 + 1, box.width - 1), y1 = std::min(y0 + 1, box.height - 1);
    const double fx = std::clamp(x - 0.5 - x0, 0.0, 1.0), fy = std::clamp(y - 0.5 - y0, 0.0, 1.0);
    const auto at = [&](int i, int j) { return static_cast<double>(signal[fine.index(i, j)]); };
    return (at(x0, y0) * (1 - fx) + at(x1, y0) * fx) * (1 - fy) +
           (at(x0, y1) * (1 - fx) + at(x1, y1) * fx) * fy;
  };
  parallel_for(static_cast<std::size_t>(box.height) * scale_, threads_, [&](std::size_t row) {
    const int fy = static_cast<int>(row);
    for (int fx = 0; fx < width; ++fx) {
      if (fine.known[fine.index(fx / scale_, fy / scale_)] == 0) continue;
      const double x = (fx + 0.5) / scale_, y = (fy + 0.5) / scale_;
      double alpha = opacity(x, y);
      if (alpha < 1.0 / 512) continue;
      if (!matte_.empty()) alpha *= std::clamp(read_bicubic(matte_, box.x + x, box.y + y, 0) / 255, 0.0, 1.0);
      std::uint8_t* to = enlarged_.at(box.x * scale_ + fx, box.y * scale_ + fy);
      const std::size_t at = row * static_cast<std::size_t>(width) + static_cast<std::size_t>(fx);
      for (std::size_t k = 0; k < 3; ++k) {
        const double detailed = static_cast<double>(photo[3 * at + k]) +
                                fine.gain[k] * static_cast<double>(fine.pixels[at][k] - coarse[3 * at + k]);
        to[k] = rounded(to[k] + alpha * (detailed - to[k]));
      }
      if (alpha >= 0.5)
        *provenance_.at(box.x * scale_ + fx, box.y * scale_ + fy) = static_cast<std::uint8_t>(as);
    }
  });
}

// The rehearsal: the photograph at half its size gets the same still's details, which are compared with what
// the photograph itself shows finer. Multiplies what is trusted by how much of it was true.
Result<void> EnlargedPhoto::prove(const Image& still, double zoom, const StillMap& map,
                                  const EnlargedBox& box, std::vector<float>& trusted) const {
  const Image photo = shrunk_by(photo_, 2), matte = matte_.empty() ? matte_ : shrunk_by(matte_, 2);
  EnlargedPhoto half(photo, matte, 2, threads_);
  const Result<CarriedStill> carried =
      half.carry(still, 2 * zoom, halved(map), detail::Provenance::Real, /*proven=*/false);
  if (!carried) return forward(carried);
  if (!carried->why_not.empty()) {
    std::fill(trusted.begin(), trusted.end(), 0.F);
    return {};
  }
  const Image plain = enlarged_picture(photo, 2, threads_);
  const Image& made = half.picture();
  const std::size_t columns = static_cast<std::size_t>(box.width) + 1;
  std::vector<double> both(columns * (static_cast<std::size_t>(box.height) + 1), 0.0),
      power(both);  // summed areas
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      double product = 0, square = 0;
      const int px = box.x + x, py = box.y + y;
      if (px < made.width && py < made.height)
        for (int k = 0; k < 3; ++k) {
          const double added = made.at(px, py)[k] - plain.at(px, py)[k],
                       missing = photo_.at(px, py)[k] - plain.at(px, py)[k];
          product += added * missing, square += added * added;
        }
      const std::size_t at = (static_cast<std::size_t>(y) + 1) * columns + static_cast<std::size_t>(x) + 1;
      both[at] = product + both[at - 1] + both[at - columns] - both[at - columns - 1];
      power[at] = square + power[at - 1] + power[at - columns] - power[at - columns - 1];
    }
  const auto sum = [&](const std::vector<double>& area, int x0, int y0, int x1, int y1) {
    const auto at = [&](int x, int y) {
      return area[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x)];
    };
    return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
  };
  const double all = sum(power, 0, 0, box.width, box.height);
  const double usual = all > 0 ? sum(both, 0, 0, box.width, box.height) / all : 0;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const int x0 = std::max(0, x - kProven), x1 = std::min(box.width, x + kProven + 1),
                y0 = std::max(0, y - kProven), y1 = std::min(box.height, y + kProven + 1);
      // Where next to nothing was added nothing was proven: what holds for the whole still counts there.
      const double unknown = static_cast<double>(kNoise) * kNoise * (x1 - x0) * (y1 - y0);
      const double share =
          (sum(both, x0, y0, x1, y1) + unknown * usual) / (sum(power, x0, y0, x1, y1) + unknown);
      trusted[static_cast<std::size_t>(y) * box.width + static_cast<std::size_t>(x)] *=
          smooth_step(kUntrue, kTrue, static_cast<float>(share));
    }
  return {};
}

Result<CarriedStill> EnlargedPhoto::carry(const Image& still, double zoom, const StillMap& map,
                                          detail::Provenance as) {
  return carry(still, zoom, map, as, /*proven=*/true);
}

Result<CarriedStill> EnlargedPhoto::carry(const Image& still, double zoom, const StillMap& map,
                                          detail::Provenance as, bool proven) {
  CarriedStill carried;
  carried.map = map;
  const EnlargedBox box = box_of(map);
  if (std::min(box.width, box.height) < (proven ? kLeastSide : kLeastSide / 2)) {
    carried.why_not = "it covers too little of the subject there";
    return carried;
  }
  const int shrunk = std::max(1, static_cast<int>(zoom / scale_));
  const Image picture = shrunk_by(still, shrunk);
  Fine fine = seen_through(picture, carried.map, box, shrunk);
  match_tones(fine, box);
  for (int round = 0; round < kRounds; ++round) {
    if (Result<void> ok = bend(fine, box, carried.map); !ok) return forward(ok);
    fine = seen_through(picture, carried.map, box, shrunk);
    match_tones(fine, box);
  }
  std::vector<float> trusted = trust(fine, box);
  if (proven)
    if (Result<void> ok = prove(still, zoom, map, box, trusted); !ok) return forward(ok);
  double used = 0, moved = 0, subject = 0;
  for (int y = 0; y < photo_.height; ++y)
    for (int x = 0; x < photo_.width; ++x) subject += is_subject(x, y) ? 1 : 0;
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      const double weight = trusted[fine.index(x, y)];
      const Eigen::Vector2f by = carried.map(box.x + x, box.y + y) - map(box.x + x, box.y + y);
      if (weight == 0 || !is_there(by)) continue;
      used += weight;
      moved += weight * static_cast<double>(by.norm()) / zoom;
    }
  carried.used = subject > 0 ? used / subject : 0;
  carried.moved = used > 0 ? moved / used : 0;
  if (carried.used < kLeastUsed) {
    carried.why_not = "the photograph shows something else where it would lie";
    return carried;
  }
  add(fine, box, trusted, as);
  return carried;
}

}  // namespace floatstage::pipeline
