#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/image.h"
#include "core/matte_edits.h"
#include "core/random.h"
#include "matting/color_model.h"
#include "matting/frame_cut.h"

namespace floatstage::matting {

/// Intersection over union of what is at least half opaque.
inline double overlap(const Image& a, const Image& b) {
  long both = 0, any = 0;
  for (std::size_t p = 0; p < a.pixels.size(); ++p) {
    const bool x = a.pixels[p] >= 128, y = b.pixels[p] >= 128;
    both += x && y, any += x || y;
  }
  return any ? static_cast<double>(both) / static_cast<double>(any) : 1;
}

/// A matte as a program makes it that knows the colours by half: a minimum cut by the colours inside and
/// outside an outline that is off, and a word on where the subject is that is worth 0.5 to 3.
inline Image doubtful_matte(const Image& picture, const Image& truth, Random& random) {
  const int off = static_cast<int>(random.uniform(0.01, 0.07) * picture.width),
            dx = random.uniform() < 0.5 ? off : -off, dy = random.uniform() < 0.5 ? off / 2 : -off / 2;
  const float word = static_cast<float>(random.uniform(0.5, 3));
  const auto moved = [&](int x, int y) {
    const int u = std::clamp(x + dx, 0, truth.width - 1), v = std::clamp(y + dy, 0, truth.height - 1);
    return *truth.at(u, v) >= 128;
  };
  ColorModel subject, background;
  for (int y = 0; y < truth.height; y += 2)
    for (int x = 0; x < truth.width; x += 2) (moved(x, y) ? subject : background).add(picture.at(x, y));
  subject.finish();
  background.finish();
  CutEvidence evidence{{}, std::vector<std::uint8_t>(truth.pixels.size(), 1), {}};
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      const float colour =
          std::log(subject.likelihood(picture.at(x, y)) / background.likelihood(picture.at(x, y)));
      evidence.odds.push_back(std::clamp(colour, -3.0f, 3.0f) + (moved(x, y) ? word : -word));
    }
  return cut_frame(picture, evidence, 2);
}

/// A click or scribble that is right: every pixel that it marks is quite of its label in `truth`. Three of
/// four begin where `matte` is wrong, if it is anywhere.
class StrokeDrawer {
 public:
  StrokeDrawer(const Image& truth, std::uint64_t seed) : truth_(truth), random_(seed) {}

  MatteStroke next(const Image& matte) {
    std::vector<std::size_t> places;
    if (random_.uniform() < 0.75)
      for (std::size_t p = 0; p < truth_.pixels.size(); ++p)
        if (clear(p) && (truth_.pixels[p] >= 128) != (matte.pixels[p] >= 128)) places.push_back(p);
    for (std::size_t p = 0; places.empty() && p < truth_.pixels.size(); ++p)
      if (clear(p)) places.push_back(p);
    // A person clicks where there is room.
    MatteStroke best;
    for (int tries = 0; tries < 20; ++tries) {
      const std::size_t p = places[static_cast<std::size_t>(random_.uniform() * places.size())];
      const int x = static_cast<int>(p % truth_.width), y = static_cast<int>(p / truth_.width);
      MatteStroke stroke{truth_.pixels[p] >= 128 ? MatteLabel::Foreground : MatteLabel::Background,
                         std::max(0.5, truth_.width / 240.0),
                         {{x + 0.5, y + 0.5}}};
      if (tries == 0) best = stroke, best.radius = 0.4;
      if (!right(stroke)) continue;
      best = stroke;
      break;
    }
    if (random_.uniform() < 0.5) drag(best);
    return best;
  }

 private:
  bool clear(std::size_t p) const { return truth_.pixels[p] >= 250 || truth_.pixels[p] <= 5; }
  bool right(const MatteStroke& stroke) const {
    Image print(truth_.width, truth_.height, 1, 128);
    paint_strokes({stroke}, 1, print);
    for (std::size_t p = 0; p < print.pixels.size(); ++p)
      if (print.pixels[p] != 128 && (!clear(p) || (print.pixels[p] >= 128) != (truth_.pixels[p] >= 128)))
        return false;
    return true;
  }
  // On from where it is, as long as it stays right.
  void drag(MatteStroke& stroke) {
    double angle = random_.uniform(0, 6.28);
    for (int i = 0; i < 5; ++i) {
      angle += random_.uniform(-0.8, 0.8);
      MatteStroke longer = stroke;
      longer.points.push_back(stroke.points.back() +
                              0.025 * truth_.width * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      if (right(longer)) stroke = std::move(longer);
    }
  }

  const Image& truth_;
  Random random_;
};

}  // namespace floatstage::matting
