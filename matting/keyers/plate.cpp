// Method:  a clean plate as the mode of each pixel, with its noise
// Paper:   after C. Stauffer, W. E. L. Grimson, "Adaptive background mixture models", 1999
// Differs: one mode, learnt once and frozen: who stands
//          still does not melt into it
// ADR:     0098

#include "matting/keyers/plate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::matting {
namespace {

constexpr int kNoiseUnit = 16;  // steps of the noise map a step of the pictures
constexpr double kMadToSigma = 1.4826;
constexpr int kFewForNoise = 4;  // samples below which a pixel's own noise means nothing
constexpr int kWhite = 250;      // of 255, in all channels: no darker than what noise leaves of white

using Pixel = std::array<std::uint8_t, 3>;

bool agree(const Pixel& a, const Pixel& b, int steps) {
  return std::abs(a[0] - b[0]) <= steps && std::abs(a[1] - b[1]) <= steps && std::abs(a[2] - b[2]) <= steps;
}

// What one pixel shows most often.
struct Mode {
  Pixel color{};
  double noise = 0;  // 8-bit steps; negative: too few samples to tell
  double share = 0;
  int count = 0;  // samples that show it
};

class ModeFinder {
 public:
  ModeFinder(int steps) : steps_(steps) {}

  Mode of(const std::vector<Pixel>& samples) {
    if (samples.empty()) return {};
    // Nearly everywhere one colour has the majority, and then the median shows it. Else the sample with most
    // company; ties go to the earlier one, so that the result does not depend on anything else.
    Pixel best{};
    for (std::size_t c = 0; c < 3; ++c) {
      values_.clear();
      for (const Pixel& s : samples) values_.push_back(s[c]);
      best[c] = percentile_in_place<std::uint8_t>(values_, 0.5);
    }
    std::size_t most = company_of(best, samples);
    if (2 * most <= samples.size()) {
      most = 0;
      for (const Pixel& s : samples)
        if (const std::size_t company = company_of(s, samples); company > most) most = company, best = s;
    }
    Mode mode;
    mode.share = static_cast<double>(most) / static_cast<double>(samples.size());
    mode.count = static_cast<int>(most);
    std::vector<std::uint8_t> spread;
    for (std::size_t c = 0; c < 3; ++c) {
      values_.clear();
      for (const Pixel& s : samples)
        if (agree(s, best, steps_)) values_.push_back(s[c]);
      mode.color[c] = percentile_in_place<std::uint8_t>(values_, 0.5);
      for (const std::uint8_t v : values_)
        spread.push_back(static_cast<std::uint8_t>(std::abs(v - mode.color[c])));
    }
    double sum = 0;  // a mean of small whole numbers says more than their median
    for (const std::uint8_t d : spread) sum += d;
    mode.noise = most < kFewForNoise ? -1 : kMadToSigma / 1.183 * sum / static_cast<double>(spread.size());
    return mode;
  }

 private:
  std::size_t company_of(const Pixel& color, const std::vector<Pixel>& samples) const {
    return static_cast<std::size_t>(std::count_if(samples.begin(), samples.end(),
                                                  [&](const Pixel& s) { return agree(s, color, steps_); }));
  }

  int steps_;
  std::vector<std::uint8_t> values_;
};

Result<void> check_photographs(const std::vector<Image>& photographs, const std::vector<Image>& subjects) {
  if (photographs.empty())
    return fail(ErrorCode::InvalidArgument, "a plate needs at least one photograph to learn from");
  const Image& first = photographs.front();
  for (const Image& p : photographs)
    if (p.channels != 3 || p.width != first.width || p.height != first.height || p.empty())
      return fail(ErrorCode::InvalidArgument,
                  text("a plate is learnt from RGB photographs of one size; these are ", first.width, "x",
                       first.height, " and ", p.width, "x", p.height, " with ", p.channels, " channels"));
  if (!subjects.empty() && subjects.size() != photographs.size())
    return fail(ErrorCode::InvalidArgument, text("a plate is learnt again from ", photographs.size(),
                                                 " photographs but ", subjects.size(), " mattes"));
  for (const Image& s : subjects)
    if (!s.empty() && (s.channels != 1 || s.width != first.width || s.height != first.height))
      return fail(ErrorCode::InvalidArgument,
                  text("a matte of ", s.width, "x", s.height, " does not fit photographs of ", first.width,
                       "x", first.height));
  return {};
}

}  // namespace

Result<void> PlateOptions::check() const {
  if (!(agree >= 1 && agree <= 128))
    return fail(ErrorCode::InvalidArgument, text("agree is ", agree, "; it must be 1 to 128 steps"));
  if (fewest < 1) return fail(ErrorCode::InvalidArgument, text("fewest is ", fewest, "; at least 1"));
  if (!(least_noise >= 0.1 && least_noise <= 15))
    return fail(ErrorCode::InvalidArgument, text("least_noise is ", least_noise, "; it must be 0.1 to 15"));
  return {};
}

Result<Plate> learn_plate(const std::vector<Image>& photographs, const PlateOptions& options,
                          const std::vector<Image>& subjects) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (Result<void> ok = check_photographs(photographs, subjects); !ok) return forward(ok);
  const Image& first = photographs.front();
  Plate plate{Image(first.width, first.height, 3), Image(first.width, first.height, 1),
              Image(first.width, first.height, 1)};
  ModeFinder finder(static_cast<int>(options.agree));
  std::vector<Pixel> samples;
  std::vector<double> all_noise;
  std::vector<float> noise(plate.noise.pixels.size());
  for (std::size_t p = 0; p < noise.size(); ++p) {
    samples.clear();
    for (const bool anything : {false, true}) {
      for (std::size_t k = 0; k < photographs.size() && (samples.empty() || !anything); ++k) {
        const bool subject = !subjects.empty() && !subjects[k].empty() && subjects[k].pixels[p] != 0;
        if (subject && !anything) continue;
        const std::uint8_t* s = photographs[k].pixels.data() + 3 * p;
        samples.push_back({s[0], s[1], s[2]});
      }
      if (!samples.empty()) break;
    }
    const Mode mode = finder.of(samples);
    std::copy_n(mode.color.data(), 3, plate.color.pixels.data() + 3 * p);
    if (mode.count >= options.fewest)
      plate.confidence.pixels[p] = static_cast<std::uint8_t>(std::max(1l, std::lround(255 * mode.share)));
    noise[p] = static_cast<float>(mode.noise);
    if (mode.noise >= 0) all_noise.push_back(mode.noise);
  }
  // A pixel that was seen too rarely to tell gets the picture's middle noise.
  const double middle = all_noise.empty() ? 2 : median(std::move(all_noise));
  for (std::size_t p = 0; p < noise.size(); ++p) {
    const double own = noise[p] < 0 ? middle : noise[p];
    plate.noise.pixels[p] =
        static_cast<std::uint8_t>(std::min(255.0, kNoiseUnit * std::max(own, options.least_noise)));
  }
  return plate;
}

double overexposed_share(const Image& photograph) {
  std::size_t white = 0;
  const auto channels = static_cast<std::ptrdiff_t>(photograph.channels);
  for (auto p = photograph.pixels.begin(); p != photograph.pixels.end(); p += channels)
    white += std::all_of(p, p + channels, [](int v) { return v >= kWhite; });
  return static_cast<double>(white) * photograph.channels / static_cast<double>(photograph.pixels.size());
}

Plate lit(Plate plate, const Image& picture, const Image& mask) {
  Image& color = plate.color;
  FLOATSTAGE_CHECK(picture.channels == 3 && picture.width == color.width && picture.height == color.height,
                   "a picture of another size than its plate");
  for (int y = 0; y < color.height; ++y)
    for (int x = 0; x < color.width; ++x)
      if (*mask.at(x * mask.width / color.width, y * mask.height / color.height) != 0)
        std::copy_n(picture.at(x, y), 3, color.at(x, y));
  return plate;
}

}  // namespace floatstage::matting
