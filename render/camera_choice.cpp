#include "render/camera_choice.h"

#include <algorithm>
#include <limits>
#include <span>

namespace floatstage::render {
namespace {

constexpr int kStandIns = 3;
constexpr double kAsNear =
    1.75;  // times the nearest one's angle: below 2, where a ring's second neighbours stand
constexpr double kLeastFade = 1e-6;  // where all of a list are as far as the next one, somebody has to count

constexpr double kNobody = std::numeric_limits<double>::infinity();  // the angle of who follows the last one

double fade(double angle, double threshold) {
  return threshold > 0 ? std::max(0.0, 1 - angle / threshold) : 0.0;
}

/// Those that stand in for the chosen ones, and how much all listed ones count where they do.
void list_stand_ins(CameraRanking& ranking, const View& view, const std::vector<bool>& pictured,
                    CameraChoice& choice) {
  ShortList<BlendedCamera, kMostListed> blended;
  for (std::size_t i = 0; i < choice.chosen; ++i)
    blended.push_back({choice.listed[i], std::max(kLeastFade, static_cast<double>(choice.fade[i]))});
  const CameraRanking::Rest rest = ranking.rank_rest(view, {blended.begin(), blended.end()});
  choice.lacking = rest.lacking;

  const std::size_t most = std::min<std::size_t>(choice.chosen + kStandIns, kMostListed);
  ShortList<double, kMostListed> angles;
  angles.resize(choice.chosen);
  double end = kNobody;  // of their fade: the camera that follows the last of them, with a picture or not
  for (const RankedCamera& camera : rest.ranked) {
    const std::span chosen(choice.listed.data(), choice.chosen);
    const auto place = std::find(chosen.begin(), chosen.end(), camera.camera);
    const bool room = choice.listed.size() < most;
    if (place != chosen.end()) {
      angles[static_cast<std::size_t>(place - chosen.begin())] = camera.angle;
      if (room || choice.chosen == most) end = kNobody;
    } else if (room && (pictured.empty() || pictured[static_cast<std::size_t>(camera.camera)])) {
      choice.listed.push_back(camera.camera);
      choice.fade.push_back(0);
      angles.push_back(camera.angle);
      end = kNobody;
    } else {
      end = std::min(end, camera.angle);
    }
  }
  if (choice.listed.empty()) return;
  // Whoever has what is missing counts as much there as the chosen ones do elsewhere.
  const double least = *std::min_element(angles.begin(), angles.end());
  const double strongest = rest.lacking > 0 ? std::max(kLeastFade, fade(least, end)) : 1;
  for (std::size_t i = 0; i < choice.listed.size(); ++i) {
    const auto own = static_cast<float>(std::max(kLeastFade, fade(angles[i], end) / strongest));
    choice.stand_in_fade.push_back(std::max(choice.fade[i], own));
  }
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
  const std::size_t next = choice.chosen == 0 ? 0 : usable[choice.chosen - 1] + 1;
  double end = next < ranked.size() ? ranked[next].angle : kNobody;  // with a picture or not
  if (choice.chosen > asked) end = std::min(as_near, end);
  for (std::size_t i = 0; i < choice.chosen; ++i) {
    const RankedCamera& camera = ranked[usable[i]];
    choice.listed.push_back(camera.camera);
    choice.fade.push_back(static_cast<float>(fade(camera.angle, end)));
  }
  list_stand_ins(ranking, view, pictured, choice);
  return choice;
}

}  // namespace floatstage::render
