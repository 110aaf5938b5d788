#include "pipeline/film_sight.h"

#include <cmath>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

long percent(double share) { return std::lround(100 * share); }

}  // namespace

void FilmSight::add(int picture, const render::SeenPixels& pixels) {
  if (pixels.shown == 0) return;
  const double share = 1 - static_cast<double>(pixels.seen) / pixels.shown;
  ++pictures;
  unseen += (share - unseen) / pictures;
  much += share > kMuchUnseen;
  if (worst_picture >= 0 && share <= worst) return;
  worst = share;
  worst_picture = picture;
}

std::optional<std::string> FilmSight::doubt() const {
  if (much == 0) return std::nullopt;
  return text(
      much, " of ", pictures, " pictures show more than ", percent(kMuchUnseen),
      " % of the subject where none of their photographs sees it (picture ", worst_picture, ": ",
      percent(worst),
      " %): it continues what is around there. --show visibility shows where, black; a greater --blend "
      "takes more photographs, and a path nearer to the cameras needs fewer");
}

}  // namespace floatstage::pipeline
