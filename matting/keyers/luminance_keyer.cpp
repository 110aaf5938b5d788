#include <algorithm>
#include <array>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/text.h"
#include "matting/keyers/keyers.h"

namespace floatstage::matting {
namespace {

// A black stage leaves dark crevices in the subject and specks on the cloth.
constexpr CleanupOptions kDefaultCleanup{.close_radius = 2, .smallest_hole = 0.003, .largest_only = true};
constexpr int kDimness = 5;  // times the threshold: as bright as black cloth gets in the subject's light
constexpr int kLeakRadius =
    2;  // px; the cloth does not leak into the subject through dim seams thinner than twice this

bool dim_at_border(const Image& alpha, const Image& grey, int dim_below) {
  auto dim = [&](int x, int y) { return *alpha.at(x, y) > 0 && *grey.at(x, y) <= dim_below; };
  for (int x = 0; x < alpha.width; ++x)
    if (dim(x, 0) || dim(x, alpha.height - 1)) return true;
  for (int y = 0; y < alpha.height; ++y)
    if (dim(0, y) || dim(alpha.width - 1, y)) return true;
  return false;
}

// Black cloth that catches light is brighter than the threshold. It is told from a dark subject by hanging at
// the picture's border: what is dim, and joined to the border by dim pixels alone, becomes background.
void drop_lit_cloth(Image& alpha, const Image& grey, int dim_below) {
  if (!dim_at_border(alpha, grey, dim_below)) return;
  cv::Mat dim(alpha.height, alpha.width, CV_8U);
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i)
    dim.data[i] = alpha.pixels[i] > 0 && grey.pixels[i] <= dim_below ? 255 : 0;
  const cv::Mat disc =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kLeakRadius + 1, 2 * kLeakRadius + 1});
  cv::Mat broad, labels;
  cv::erode(dim, broad, disc);  // outside the picture counts as dim, so that cloth at the border stays there
  const int count = cv::connectedComponents(broad, labels, 4, CV_32S, cv::CCL_SAUF);
  std::vector<std::uint8_t> at_border(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; x += y == 0 || y == alpha.height - 1 ? 1 : std::max(alpha.width - 1, 1))
      at_border[static_cast<std::size_t>(labels.at<int>(y, x))] = 1;
  at_border[0] = 0;
  cv::Mat cloth(alpha.height, alpha.width, CV_8U);
  for (int y = 0; y < alpha.height; ++y) {
    const int* label = labels.ptr<int>(y);
    std::uint8_t* row = cloth.ptr<std::uint8_t>(y);
    for (int x = 0; x < alpha.width; ++x) row[x] = at_border[static_cast<std::size_t>(label[x])] ? 255 : 0;
  }
  cv::dilate(cloth, cloth, disc);
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i)
    if (cloth.data[i] && dim.data[i]) alpha.pixels[i] = 0;
}

class LuminanceKeyer : public Keyer {
 public:
  LuminanceKeyer(int threshold, const CleanupOptions& cleanup) : threshold_(threshold), cleanup_(cleanup) {
    // A ramp from half the threshold to one and a half: 128 and above exactly where grey > threshold.
    for (int grey = 0; grey < 256; ++grey)
      alpha_[static_cast<std::size_t>(grey)] =
          static_cast<std::uint8_t>(std::clamp((2 * grey - threshold) * 255 / (2 * threshold), 0, 255));
  }

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    Image grey(rgb->width, rgb->height, 1), alpha(rgb->width, rgb->height, 1);
    for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
      const std::uint8_t* p = rgb->pixels.data() + 3 * i;
      grey.pixels[i] = static_cast<std::uint8_t>((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8);  // BT.601
      alpha.pixels[i] = alpha_[grey.pixels[i]];
    }
    drop_lit_cloth(alpha, grey, kDimness * threshold_);
    return make_matte(frame.info, clean_up(alpha, cleanup_));
  }

  Result<Image> suppress_spill(const Frame& frame) const override { return to_rgb(frame); }
  std::string spec() const override { return text("luminance:", threshold_); }
  CleanupOptions cleanup() const override { return cleanup_; }

 private:
  int threshold_;
  CleanupOptions cleanup_;
  std::array<std::uint8_t, 256> alpha_{};
};

}  // namespace

Result<std::unique_ptr<Keyer>> make_luminance_keyer(const KeyerRequest& request) {
  const auto threshold = threshold_of(request, "luminance", 12);
  if (!threshold) return forward(threshold);
  return std::unique_ptr<Keyer>(new LuminanceKeyer(*threshold, request.cleanup.value_or(kDefaultCleanup)));
}

}  // namespace floatstage::matting
