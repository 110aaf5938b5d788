// Method:  graph cut between colours inside and outside the others' hull, in turns
// Paper:   W. Lee, W. Woo, E. Boyer, "Silhouette Segmentation in Multiple Views", PAMI 2011, sections 4 and 5
// Differs: one picture at a time; the hull of the believed mattes is the only word on space; all believed
//          mattes teach the subject's colours
// ADR:     0194

#include "pipeline/matte/rekey.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/view_colors.h"
#include "matting/view_cut.h"

namespace floatstage::pipeline {
namespace {

using matting::Certain;

constexpr float kColor = 4;     // log-odds at most by colours
constexpr float kWithin = 1.5;  // of a place that all others hold for subject: as kAllAgree of consistent.cpp
constexpr int kMargin = 3;      // working pixels around the hull: it lacks what the others' mattes lack
constexpr double kFirstNovelty = 0.2, kNovelty = 0.05;  // as in consistent.cpp
constexpr double kSmooth = 3;

Eigen::Vector2i working_size(const Image& picture, int pixels) {
  const double all = static_cast<double>(picture.width) * picture.height,
               shrink = std::min(1.0, std::sqrt(pixels / all));
  return {std::max(3, static_cast<int>(std::lround(picture.width * shrink))),
          std::max(3, static_cast<int>(std::lround(picture.height * shrink)))};
}

Image small_matte(const Matte& matte, const Eigen::Vector2i& size) {
  return matting::shrunk(to_image(matte), size.x(), size.y());
}

// 255 within `reach` pixels, by squares, of what is at least half.
Image grown(const Image& mask, int reach) {
  Image from = mask, to(mask.width, mask.height, 1);
  for (const bool rows : {true, false}) {
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        int most = 0;
        for (int s = -reach; s <= reach; ++s) {
          const int u = rows ? x + s : x, v = rows ? y : y + s;
          if (u >= 0 && v >= 0 && u < mask.width && v < mask.height)
            most = std::max<int>(most, *from.at(u, v));
        }
        *to.at(x, y) = most >= 128 ? 255 : 0;
      }
    std::swap(from, to);
  }
  return from;
}

/// What the turns work on; the picture in question is the first.
struct Bench {
  std::vector<Image> pictures;
  std::vector<std::vector<float>> shares;
  Image hull;
  std::vector<Certain> certain;
};

Bench laid_out(const Image& picture, const Matte& hull, std::span<const Witness> witnesses,
               const RekeyOptions& options) {
  Bench bench;
  const Eigen::Vector2i size = working_size(picture, options.working_pixels);
  bench.pictures.push_back(matting::shrunk(picture, size.x(), size.y()));
  bench.hull = small_matte(hull, size);
  const Image around = grown(bench.hull, kMargin);
  std::vector<float> share;
  for (const std::uint8_t in : around.pixels) {
    share.push_back(in ? -1.0f : 0.0f);
    bench.certain.push_back(in ? Certain::No : Certain::Backdrop);
  }
  bench.shares.push_back(std::move(share));
  for (const Witness& w : witnesses) {
    const Eigen::Vector2i s = working_size(w.picture, options.working_pixels);
    bench.pictures.push_back(matting::shrunk(w.picture, s.x(), s.y()));
    std::vector<float> of;
    for (const std::uint8_t a : small_matte(w.matte, s).pixels) of.push_back(static_cast<float>(a) / 255);
    bench.shares.push_back(std::move(of));
  }
  return bench;
}

Result<void> check(const Image& picture, const Matte& hull, std::span<const Witness> witnesses) {
  const auto fits = [](const Image& p, const Matte& m) {
    return p.channels == 3 && m.width == p.width && m.height == p.height && !m.empty();
  };
  bool all = fits(picture, hull);
  for (const Witness& w : witnesses) all = all && fits(w.picture, w.matte);
  if (!all)
    return fail(ErrorCode::InvalidArgument, "pictures are RGB, and their mattes and hull of their size");
  if (witnesses.empty()) return fail(ErrorCode::BadData, "no other camera has a matte that is believed");
  const double seen = coverage(hull);
  if (seen <= 0 || seen >= 1)
    return fail(ErrorCode::BadData, seen <= 0 ? "what the others see is not in the picture"
                                              : "what the others see fills the picture");
  return {};
}

}  // namespace

Result<Image> rekey(const Image& picture, const Matte& hull, std::span<const Witness> witnesses,
                    const RekeyOptions& options) {
  if (Result<void> ok = check(picture, hull, witnesses); !ok) return forward(ok);
  Bench bench = laid_out(picture, hull, witnesses, options);
  Image label;
  for (int turn = 0; turn < options.turns; ++turn) {
    const matting::ViewColors colors(bench.pictures, bench.shares, turn ? kNovelty : kFirstNovelty,
                                     options.threads);
    std::vector<float> odds = colors.odds(0, bench.pictures[0]);
    for (std::size_t p = 0; p < odds.size(); ++p)
      odds[p] = std::clamp(odds[p], -kColor, kColor) + (bench.hull.pixels[p] >= 128 ? kWithin : -kWithin);
    Image cut = matting::cut_view(bench.pictures[0], odds, bench.certain, kSmooth);
    if (cut.pixels == label.pixels) break;
    label = std::move(cut);
    for (std::size_t p = 0; p < odds.size(); ++p) bench.shares[0][p] = label.pixels[p] ? 1.0f : 0.0f;
  }
  return matting::refine_matte(picture, label, matting::key_refinement(), {});
}

}  // namespace floatstage::pipeline
