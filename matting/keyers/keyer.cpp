#include "matting/keyers/keyer.h"

#include <array>
#include <charconv>

#include "core/added_search.h"
#include "core/text.h"
#include "matting/keyers/added_frame.h"
#include "matting/keyers/keyers.h"

namespace floatstage::matting {
namespace {

struct Entry {
  const char* name;
  const char* help;
  Result<std::unique_ptr<Keyer>> (*make)(const KeyerRequest&);
};

// To add a keyer: one file, one line in keyers.h, one line here. The conformance test runs over this table.
constexpr std::array kTable = {
    Entry{"chroma", "chroma or chroma:#rrggbb: a green or blue cloth; its colour is sampled when not given",
          make_chroma_keyer},
    Entry{"difference", "difference or difference:T: against a clean plate, threshold T in 8-bit steps (24)",
          make_difference_keyer},
    Entry{"luminance",
          "luminance or luminance:T: a black stage, measured; with T only grey above it is subject",
          make_luminance_keyer},
    Entry{"plate",
          "plate or plate:K: against a plate learnt from several pictures, K times each pixel's noise (6)",
          [](const KeyerRequest& request) { return make_plate_keyer(request); }},
};

Result<Image> as_rgb(const Image& sample) {
  const std::size_t bytes = static_cast<std::size_t>(sample.width) * sample.height * sample.channels;
  if (sample.empty() || sample.pixels.size() != bytes || (sample.channels != 1 && sample.channels != 3))
    return fail(ErrorCode::InvalidArgument,
                text("a keyer's sample is ", sample.width, "x", sample.height, " with ", sample.channels,
                     " channels; give grey or RGB pictures"));
  if (sample.channels == 3) return sample;
  Image rgb(sample.width, sample.height, 3);
  for (std::size_t i = 0; i < bytes; ++i)
    rgb.pixels[3 * i] = rgb.pixels[3 * i + 1] = rgb.pixels[3 * i + 2] = sample.pixels[i];
  return rgb;
}

}  // namespace

Result<std::unique_ptr<Keyer>> make_keyer(std::string_view spec, const std::vector<Image>& samples,
                                          const std::optional<CleanupOptions>& cleanup) {
  const std::size_t colon = spec.find(':');
  const std::string_view name = spec.substr(0, colon);
  for (const Entry& entry : kTable) {
    if (name != entry.name) continue;
    std::vector<Image> rgb;
    for (const Image& sample : samples) {
      auto converted = as_rgb(sample);
      if (!converted) return forward(converted);
      rgb.push_back(std::move(*converted));
    }
    const AddedContent frame = added_bars(rgb);
    const int width = rgb.empty() ? 0 : rgb.front().width, height = rgb.empty() ? 0 : rgb.front().height;
    for (Image& sample : rgb)
      if (!frame.none() && sample.width == width && sample.height == height) sample = inside(sample, frame);
    KeyerRequest request{std::nullopt, rgb, cleanup};
    if (colon != std::string_view::npos) request.parameter = spec.substr(colon + 1);
    Result<std::unique_ptr<Keyer>> keyer = entry.make(request);
    if (!keyer || frame.none()) return keyer;
    return inside_keyer(std::move(*keyer), frame);
  }
  std::string names;
  for (const Entry& entry : kTable) names += text(names.empty() ? "" : ", ", entry.name);
  return fail(ErrorCode::InvalidArgument, text("no keyer is called '", name, "'; the keyers are ", names));
}

std::vector<KeyerInfo> keyers() {
  std::vector<KeyerInfo> all;
  for (const Entry& entry : kTable) all.push_back({entry.name, entry.help});
  return all;
}

Result<int> threshold_of(const KeyerRequest& request, std::string_view keyer, int fallback) {
  if (!request.parameter) return fallback;
  const std::string_view digits = *request.parameter;
  int value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || value < 1 || value > 254)
    return fail(ErrorCode::InvalidArgument,
                text("'", keyer, ":", digits, "': the threshold must be a whole number from 1 to 254, as in ",
                     keyer, ":", fallback));
  return value;
}

}  // namespace floatstage::matting
