// Method:  closed-form matting in the unknown band, by a sparse Cholesky factor
// Paper:   A. Levin, D. Lischinski, Y. Weiss, "A closed-form solution to natural image matting", 2008, eq.
//          15
// Differs: only unknown pixels and what they touch take part; large bands begin at half the size
// ADR:     0097

#include "matting/closed_form.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/text.h"
#include "matting/band_solver.h"
#include "matting/half_trimap.h"
#include "matting/image_mat.h"
#include "matting/picture_scale.h"

namespace floatstage::matting {
namespace {

constexpr int kReach = 2;  // px: rows of L reach this far
// Scribbles are black and white strokes; a picture that was coded anew differs nearly everywhere by a little.
constexpr int kBlack = 5, kWhite = 250;
constexpr double kMostChanged = 0.9;

struct Box {
  int x0, y0, x1, y1;  // ends excluded
};

bool same_size(const Image& a, const Image& b) { return a.width == b.width && a.height == b.height; }
bool known(std::uint8_t v) { return v == 0 || v == 255; }

Image crop(const Image& image, const Box& box) {
  Image out(box.x1 - box.x0, box.y1 - box.y0, image.channels);
  for (int y = box.y0; y < box.y1; ++y)
    std::copy_n(image.at(box.x0, y), static_cast<std::size_t>(out.width) * out.channels,
                out.at(0, y - box.y0));
  return out;
}

Result<void> check_inputs(const Image& picture, const Image& trimap, const Image& prior,
                          const Image& weight) {
  if ((picture.channels != 1 && picture.channels != 3) || picture.width < 3 || picture.height < 3)
    return fail(ErrorCode::InvalidArgument,
                text("closed-form matting needs a grey or RGB picture of at least 3x3, not ", picture.width,
                     "x", picture.height, " with ", picture.channels, " channels"));
  for (const Image* map : {&trimap, &prior, &weight}) {
    if (map != &trimap && map->empty()) continue;
    if (map->channels != 1 || !same_size(*map, picture))
      return fail(ErrorCode::InvalidArgument,
                  text("the trimap or prior is ", map->width, "x", map->height, " with ", map->channels,
                       " channels, but the picture is ", picture.width, "x", picture.height));
  }
  return {};
}

Result<Image> coarse_to_fine(const Image& picture, const Image& trimap, const ClosedFormOptions& options,
                             const Image& prior, const Image& weight) {
  const int w = picture.width / 2, h = picture.height / 2;
  if (w < 3 || h < 3) return fail(ErrorCode::InvalidArgument, "most_unknown is too small for any picture");
  const auto half = [&](const Image& map) { return map.empty() ? Image() : scaled(map, w, h); };
  Result<Image> small =
      closed_form_matte(scaled(picture, w, h), half_trimap(trimap, w, h), options, half(prior), half(weight));
  if (!small) return small;
  RefineOptions refine;
  refine.solve = options;
  return refine_matte(picture, *small, refine, trimap);
}

Result<Image> solve_box(const Image& picture, const Image& trimap, const ClosedFormOptions& options,
                        const Image& prior, const Image& weight) {
  // A pixel takes part where a window joins it to an unknown one.
  Image mask(trimap.width, trimap.height, 1);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) mask.pixels[i] = known(trimap.pixels[i]) ? 255 : 0;
  LaplacianStencil stencil;
  build_stencil(picture, options.laplacian.epsilon, mask, stencil);
  const std::size_t n = stencil.pixels();
  std::vector<std::uint8_t> active(n);
  std::vector<double> hold(n), value(n);
  for (std::size_t p = 0; p < n; ++p) {
    active[p] = !mask.pixels[p] || stencil.planes[0][p] > 0;
    if (mask.pixels[p]) {
      hold[p] = options.constraint;
      value[p] = trimap.pixels[p] / 255.0;
    } else if (options.prior > 0 && !prior.empty()) {
      hold[p] = options.prior * (weight.empty() ? 1.0 : weight.pixels[p] / 255.0);
      value[p] = prior.pixels[p] / 255.0;
    }
  }
  Result<std::vector<double>> alpha = solve_band(stencil, active, hold, value);
  if (!alpha) return forward(alpha);
  Image out = trimap;
  for (std::size_t p = 0; p < n; ++p)
    if (active[p])
      out.pixels[p] = static_cast<std::uint8_t>(std::lround(255 * std::clamp((*alpha)[p], 0.0, 1.0)));
  return out;
}

}  // namespace

Result<void> ClosedFormOptions::check() const {
  if (Result<void> ok = laplacian.check(); !ok) return ok;
  if (!(constraint > 0))
    return fail(ErrorCode::InvalidArgument, text("constraint is ", constraint, "; it must be positive"));
  if (!(prior >= 0 && prior <= 1e3))
    return fail(ErrorCode::InvalidArgument, text("prior is ", prior, "; it must be 0 to 1000"));
  if (most_unknown < 1000)
    return fail(ErrorCode::InvalidArgument,
                text("most_unknown is ", most_unknown, "; it must be at least 1000"));
  return {};
}

Result<Image> closed_form_matte(const Image& picture, const Image& trimap, const ClosedFormOptions& options,
                                const Image& prior_opacity, const Image& prior_weight) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (Result<void> ok = check_inputs(picture, trimap, prior_opacity, prior_weight); !ok) return forward(ok);
  Box box{picture.width, picture.height, 0, 0};
  long unknown = 0;
  for (int y = 0; y < trimap.height; ++y) {
    for (int x = 0; x < trimap.width; ++x) {
      if (known(*trimap.at(x, y))) continue;
      ++unknown;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1), std::max(box.y1, y + 1)};
    }
  }
  if (unknown == 0) return trimap;
  const bool held = options.prior > 0 && !prior_opacity.empty();
  if (unknown == static_cast<long>(trimap.pixels.size()) && !held)
    return fail(ErrorCode::InvalidArgument,
                "nothing in the trimap is known; mark some background (0) and some subject (255)");
  if (unknown > options.most_unknown)
    return coarse_to_fine(picture, trimap, options, prior_opacity, prior_weight);

  const auto widen = [](int& low, int& high, int size) {
    low = std::max(0, low - kReach - 1);
    high = std::min(size, high + kReach + 1);
    if (high - low < 3) low = std::max(0, high - 3), high = std::min(size, low + 3);
  };
  widen(box.x0, box.x1, picture.width);
  widen(box.y0, box.y1, picture.height);
  const auto cropped = [&](const Image& map) { return map.empty() ? Image() : crop(map, box); };
  Result<Image> part = solve_box(crop(picture, box), crop(trimap, box), options, cropped(prior_opacity),
                                 cropped(prior_weight));
  if (!part) return part;
  Image out = trimap;
  for (int y = box.y0; y < box.y1; ++y)
    std::copy_n(part->at(0, y - box.y0), static_cast<std::size_t>(part->width), out.at(box.x0, y));
  return out;
}

Image trimap_around(const Image& matte, const TrimapOptions& options) {
  if (matte.empty()) return matte;
  const cv::Mat alpha = as_mat(matte);
  cv::Mat soft, low, high;
  cv::inRange(alpha, cv::Scalar(options.soft_from), cv::Scalar(options.soft_to), soft);
  const cv::Mat subject = alpha >= 128;
  // Hard edges have no soft pixels: the two pixels that an edge runs between.
  cv::erode(subject, low, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  cv::dilate(subject, high, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  cv::Mat unknown = soft | (high & ~low);
  if (options.margin > 0) {
    const int size = 2 * options.margin + 1;
    cv::dilate(unknown, unknown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size}));
  }
  Image out(matte.width, matte.height, 1);
  cv::Mat map = as_mat(out);
  map.setTo(255, subject);
  map.setTo(128, unknown);
  return out;
}

Result<Image> trimap_from_scribbles(const Image& picture, const Image& scribbled) {
  if (!same_size(picture, scribbled) || picture.channels != scribbled.channels)
    return fail(ErrorCode::InvalidArgument,
                text("the scribbled picture is ", scribbled.width, "x", scribbled.height, " with ",
                     scribbled.channels, " channels, but the picture is ", picture.width, "x", picture.height,
                     " with ", picture.channels));
  Image out(picture.width, picture.height, 1, 128);
  const std::size_t channels = static_cast<std::size_t>(picture.channels);
  long changed = 0;
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    const std::uint8_t *a = picture.pixels.data() + i * channels, *b = scribbled.pixels.data() + i * channels;
    if (std::equal(a, a + channels, b)) continue;
    out.pixels[i] = b[0] >= 128 ? 255 : 0;
    changed += std::any_of(b, b + channels, [](int v) { return v > kBlack && v < kWhite; });
  }
  if (changed > kMostChanged * static_cast<double>(out.pixels.size()))
    return fail(
        ErrorCode::InvalidArgument,
        text("the scribbled picture differs from the picture in ",
             std::lround(100.0 * static_cast<double>(changed) / static_cast<double>(out.pixels.size())),
             " % of its pixels, so that it is not the same picture painted on; save the picture "
             "without loss (PNG) and paint on that"));
  return out;
}

}  // namespace floatstage::matting
