#include "render/camera_choice.h"

#include <algorithm>
#include <optional>
#include <span>

namespace floatstage::render {
namespace {

constexpr int kStandIns = 3;
constexpr double kAsNear =
    1.75;  // times the nearest one's angle: below 2, where a ring's second neighbours stand
constexpr double kLeastFade = 1e-6;  // where all of a list are as far as the next one, somebody has to count

double fade(double angle, double threshold) {
  return threshold > 0 ? std::max(0.0, 1 - angle / threshold) : 0.0;
}

}  // namespace

CameraChoice choose_cameras(CameraRanking& ranking, const View& view, int count,
                            const std::vector<bool>& pictured) {
  const std::span<const RankedCamera> ranked = ranking.rank(view);
  const auto is_usable = [&](std::size_t rank) {
    return pictured.empty() || pictured[static_cast<std::size_t>(ranked[rank].camera)];
  };
  // The ranks of the nearest cameras with a picture: more than a list can hold are of no use.
  ShortList<std::size_t, kMostListed> usable;
  for (std::size_t rank = 0; rank < ranked.size() && usable.size() < kMostListed; ++rank)
    if (is_usable(rank)) usable.push_back(rank);

  CameraChoice choice;
  const auto blended = static_cast<std::size_t>(count), asked = std::min(blended, usable.size()),
             most = std::min({usable.size(), 2 * blended, static_cast<std::size_t>(kMostListed)});
  const double as_near = count > 1 && !ranked.empty() ? kAsNear * ranked[0].angle : 0;
  choice.chosen = asked;
  while (choice.chosen < most && ranked[usable[choice.chosen]].angle < as_near) ++choice.chosen;
  const std::size_t listed =
      std::min({usable.size(), choice.chosen + kStandIns, static_cast<std::size_t>(kMostListed)});
  // A fade ends at the camera that follows the last of its list, with a picture or without.
  auto end_of_fade = [&](std::size_t members) -> std::optional<double> {
    const std::size_t rank = members == 0 ? 0 : usable[members - 1] + 1;
    if (rank >= ranked.size()) return std::nullopt;
    return ranked[rank].angle;
  };
  const std::optional<double> listed_end = end_of_fade(listed);
  std::optional<double> chosen_end = end_of_fade(choice.chosen);
  if (choice.chosen > asked) chosen_end = std::min(as_near, chosen_end.value_or(as_near));
  for (std::size_t i = 0; i < listed; ++i) {
    const double a = ranked[usable[i]].angle;
    choice.listed.push_back(ranked[usable[i]].camera);
    choice.fade.push_back(static_cast<float>(i >= choice.chosen ? 0 : chosen_end ? fade(a, *chosen_end) : 1));
    choice.stand_in_fade.push_back(
        static_cast<float>(listed_end ? std::max(kLeastFade, fade(a, *listed_end)) : 1));
  }
  return choice;
}

}  // namespace floatstage::render
