#include "matting/keyers/keyer_choice.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>

#include "core/frame.h"
#include "core/matte.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {
namespace {

constexpr double kMostSubject = 0.6;    // of a photograph: more is no studio, but cloth on the floor
constexpr double kMostFixtures = 0.02;  // of an empty stage, where the cloth is not
constexpr double kDark = 48;            // grey, in the mean: a black stage where nobody shows how dark it is

// The largest share of a sample that a keyer takes for subject; nothing where it cannot key one.
std::optional<double> subject_in(const char* word, const KeySamples& samples) {
  const Result<std::unique_ptr<Keyer>> keyer = make_keyer(word, samples.pictures);
  if (!keyer) return std::nullopt;
  double most = 0;
  for (const Image& picture : samples.pictures) {
    const Result<Matte> matte = (*keyer)->key(make_frame({}, picture));
    if (!matte) return std::nullopt;
    most = std::max(most, coverage(*matte));
  }
  return most;
}

double mean_of(const std::vector<Image>& pictures) {
  double sum = 0, count = 0;
  for (const Image& picture : pictures) {
    sum = std::accumulate(picture.pixels.begin(), picture.pixels.end(), sum);
    count += static_cast<double>(picture.pixels.size());
  }
  return count > 0 ? sum / count : 0;
}

std::string choose(const KeySamples& samples) {
  if (samples.pictures.empty()) return "";
  const std::optional<double> cloth = subject_in("chroma", samples);
  if (cloth && *cloth <= (samples.empty_stage ? kMostFixtures : kMostSubject)) return "chroma";
  if (samples.empty_stage) return "plate";
  const std::optional<double> black = subject_in("luminance", samples);
  if (!black || *black > kMostSubject) return "";
  return *black > 0 || mean_of(samples.pictures) < kDark ? "luminance" : "";
}

}  // namespace

std::vector<std::string> choose_keyers(const std::vector<KeySamples>& cameras) {
  std::vector<std::string> words;
  for (const KeySamples& samples : cameras) words.push_back(choose(samples));
  if (std::count(words.begin(), words.end(), "plate") > 0)
    for (std::size_t c = 0; c < words.size(); ++c)
      if (cameras[c].empty_stage) words[c] = "plate";
  return words;
}

}  // namespace floatstage::matting
