#pragma once

namespace floatstage::render {

/// Goes over `height` rows once, as a wave: while row t is warped, row t - 1 is differentiated, row t - 2
/// gets its equations and half-sweep h relaxes the pixels of one parity of row t - 2 - h. The same result,
/// bit by bit, as one pass after the other.
template <class Warp, class Differentiate, class Equate, class Relax>
void row_wave(int height, int sweeps, const Warp& warp, const Differentiate& differentiate,
              const Equate& equate, const Relax& relax) {
  const int halves = 2 * sweeps;
  for (int t = 0; t < height + 2 + halves; ++t) {
    if (t < height) warp(t);
    if (t >= 1 && t - 1 < height) differentiate(t - 1);
    if (t >= 2 && t - 2 < height) equate(t - 2);
    for (int h = 0; h < halves; ++h) {
      const int y = t - 2 - h;
      if (y >= 0 && y < height) relax(y, (y + h) & 1);
    }
  }
}

}  // namespace floatstage::render
