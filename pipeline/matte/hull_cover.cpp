#include "pipeline/matte/hull_cover.h"

#include <cmath>

namespace floatstage::pipeline {
namespace {

constexpr double kCovered = 0.9;  // of a silhouette: given mattes and rigs leave less open on every set
constexpr double kOpen = 0.05;    // of a silhouette: less cannot hold what contradiction_in() asks for

}  // namespace

bool poorly_covered(const std::vector<double>& iou) {
  int known = 0, poor = 0;
  for (const double one : iou)
    if (!std::isnan(one)) ++known, poor += one < kCovered;
  return known >= 4 && 2 * poor >= known;
}

bool leaves_much_open(const recon::HullReport& hull) {
  int known = 0, open = 0;
  for (std::size_t c = 0; c < hull.silhouette_iou.size(); ++c) {
    if (std::isnan(hull.silhouette_iou[c])) continue;
    const double by_cleanup = hull.cleanup ? hull.cleanup->iou_loss[c] : 0;
    ++known, open += 1 - hull.silhouette_iou[c] - by_cleanup > kOpen;
  }
  return known > 0 && 2 * open >= known;
}

}  // namespace floatstage::pipeline
