#include "recon/hull_cover.h"

#include <algorithm>
#include <cmath>

namespace floatstage::recon {
namespace {

constexpr double kCovered = 0.9;  // of a silhouette: given mattes and rigs leave less open on every set
constexpr double kOpen = 0.05;    // of a silhouette
constexpr int kFewCameras = 6;    // fewer have little to deny with
constexpr double kPieceOfFew = 0.015, kPiece = 0.03;  // of a matte

// Whether more than this share of half of the silhouettes is open.
bool leaves_open(const HullReport& hull, double most) {
  int known = 0, open = 0;
  for (std::size_t c = 0; c < hull.silhouette_iou.size(); ++c) {
    if (std::isnan(hull.silhouette_iou[c])) continue;
    const double by_cleanup = hull.cleanup ? hull.cleanup->iou_loss[c] : 0;
    ++known, open += 1 - hull.silhouette_iou[c] - by_cleanup > most;
  }
  return known > 0 && 2 * open >= known;
}

}  // namespace

bool poorly_covered(const std::vector<double>& iou) {
  int known = 0, poor = 0;
  for (const double one : iou)
    if (!std::isnan(one)) ++known, poor += one < kCovered;
  return known >= 4 && 2 * poor >= known;
}

double most_in_pieces(int cameras) { return cameras < kFewCameras ? kPieceOfFew : kPiece; }

bool may_contradict(const HullReport& hull) {
  const auto known = std::count_if(hull.silhouette_iou.begin(), hull.silhouette_iou.end(),
                                   [](double iou) { return !std::isnan(iou); });
  return leaves_open(hull, most_in_pieces(static_cast<int>(known)));
}

bool leaves_much_open(const HullReport& hull) { return leaves_open(hull, kOpen); }

}  // namespace floatstage::recon
