#include "recon/silhouette_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "recon/mesh/mesh_mask.h"
#include "recon/visual_hull.h"

namespace floatstage::recon {
namespace {

bool shows_subject(const Matte& matte) { return !matte.empty() && coverage(matte) > 0; }

constexpr int kOutlineSlack = 2;      // px that outlines of photographs are off by, and then some
constexpr double kThickPiece = 0.02;  // of the square root of a matte's area, to either side of a pixel

// Whether the picture has subject within `reach` pixels, by squares.
bool has_subject_near(const Matte& m, int x, int y, int reach) {
  for (int v = std::max(0, y - reach); v <= std::min(m.height - 1, y + reach); ++v)
    for (int u = std::max(0, x - reach); u <= std::min(m.width - 1, x + reach); ++u)
      if (m.row(v)[u] >= 128) return true;
  return false;
}

// How many pixels are marked within squares.
class SquareCounts {
 public:
  SquareCounts(int width, int height, const std::vector<char>& marked)
      : width_(width), height_(height), sums_((stride() + 1) * static_cast<std::size_t>(height + 1)) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        sum(x + 1, y + 1) = sum(x, y + 1) + sum(x + 1, y) - sum(x, y) + marked[index(x, y)];
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  // Of the pixels up to `reach` to each side.
  int around(int x, int y, int reach) {
    const int x0 = std::max(0, x - reach), y0 = std::max(0, y - reach), x1 = std::min(width_, x + reach + 1),
              y1 = std::min(height_, y + reach + 1);
    return sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0);
  }

 private:
  std::size_t stride() const { return static_cast<std::size_t>(width_) + 1; }
  int& sum(int x, int y) {
    return sums_[static_cast<std::size_t>(y) * stride() + static_cast<std::size_t>(x)];
  }

  int width_, height_;
  std::vector<int> sums_;
};

// Share of `matte` that lies farther than `slack` pixels outside of `hull`.
double share_outside(const Matte& matte, const Matte& hull, int slack) {
  std::size_t all = 0, outside = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (matte.row(y)[x] < 128) continue;
      ++all;
      outside += !has_subject_near(hull, x, y, slack);
    }
  return all ? static_cast<double>(outside) / static_cast<double>(all) : 0;
}

}  // namespace

double denied_share(const Matte& matte, const Matte& hull) {
  return share_outside(matte, hull, kOutlineSlack);
}

// A morphological opening by squares.
double denied_pieces(const Matte& matte, const Matte& hull) {
  const int w = matte.width, h = matte.height;
  std::vector<char> denied(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)), inner = denied;
  std::size_t all = 0, thick = 0;
  std::size_t p = 0;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x, ++p) {
      if (matte.row(y)[x] < 128) continue;
      ++all;
      denied[p] = !has_subject_near(hull, x, y, kOutlineSlack);
    }
  if (all == 0) return 0;
  const int reach = std::max(1, static_cast<int>(kThickPiece * std::sqrt(static_cast<double>(all)))),
            full = (2 * reach + 1) * (2 * reach + 1);
  SquareCounts of_denied(w, h, denied);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) inner[of_denied.index(x, y)] = of_denied.around(x, y, reach) == full;
  SquareCounts of_inner(w, h, inner);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) thick += denied[of_inner.index(x, y)] && of_inner.around(x, y, reach) > 0;
  return static_cast<double>(thick) / static_cast<double>(all);
}

std::optional<Matte> silhouette_of_others(const Rig& rig, const std::vector<Matte>& mattes,
                                          std::size_t camera) {
  std::vector<Matte> others = mattes;
  others[camera] = {};
  if (std::count_if(others.begin(), others.end(), shows_subject) < 2) return std::nullopt;
  HullOptions options;
  options.quality = false;
  options.threads = 1;
  const Result<HullReport> hull = visual_hull(rig, others, options);
  if (!hull) return std::nullopt;  // they bound no space
  return mesh_mask(rig.cameras[camera], hull->mesh);
}

SilhouetteAgreement agreement_with(const std::string& serial, int frame, const Matte& matte,
                                   const Matte& hull) {
  if (!shows_subject(hull)) {  // the others agree on nothing at all
    const bool both = !shows_subject(matte);
    return {serial, frame, both ? 1.0 : 0.0, 1, 1, 1};
  }
  return {serial,
          frame,
          iou(matte, hull),
          share_outside(matte, hull, 0),
          denied_share(matte, hull),
          denied_pieces(matte, hull)};
}

std::vector<SilhouetteAgreement> agreement_between(const Rig& rig, const std::vector<Matte>& mattes,
                                                   int frame) {
  std::vector<SilhouetteAgreement> found;
  for (std::size_t i = 0; i < mattes.size(); ++i) {
    if (mattes[i].empty()) continue;
    if (const std::optional<Matte> silhouette = silhouette_of_others(rig, mattes, i))
      found.push_back(agreement_with(rig.cameras[i].serial, frame, mattes[i], *silhouette));
  }
  return found;
}

}  // namespace floatstage::recon
