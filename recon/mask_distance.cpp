#include "recon/mask_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace floatstage::recon {
namespace {

bool in(const Matte& mask, int x, int y) {
  return x >= 0 && y >= 0 && x < mask.width && y < mask.height && mask.row(y)[x] >= 128;
}

// Distance from a pixel to the nearest of `mask`, looked for in growing squares around it.
double nearest(const Matte& mask, int x, int y) {
  const int limit = std::max(mask.width, mask.height);
  double best = std::hypot(mask.width, mask.height);
  for (int r = 1; r < limit && r < best; ++r) {
    for (int k = -r; k <= r; ++k) {
      if (in(mask, x + k, y - r) || in(mask, x + k, y + r) || in(mask, x - r, y + k) ||
          in(mask, x + r, y + k))
        best = std::min(best, std::hypot(r, k));
    }
  }
  return best;
}

double furthest(const Matte& from, const Matte& to) {
  double distance = 0;
  for (int y = 0; y < from.height; ++y) {
    for (int x = 0; x < from.width; ++x)
      if (in(from, x, y) && !in(to, x, y)) distance = std::max(distance, nearest(to, x, y));
  }
  return distance;
}

}  // namespace

double mask_distance(const Matte& a, const Matte& b) {
  const bool a_empty = coverage(a) == 0, b_empty = coverage(b) == 0;
  if (a_empty && b_empty) return 0;
  if (a_empty || b_empty) return std::hypot(a.width, a.height);
  return std::max(furthest(a, b), furthest(b, a));
}

}  // namespace floatstage::recon
