#include "apps/matte/matte_doubts.h"

#include <set>

#include <nlohmann/json.hpp>

#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage::apps {

nlohmann::json doubts_json(const std::vector<pipeline::MatteDoubt>& doubts) {
  nlohmann::json j = nlohmann::json::array();
  for (const pipeline::MatteDoubt& d : doubts)
    j.push_back({{"why", d.why},
                 {"cameras", d.cameras},
                 {"frames", d.frames},
                 {"worst_frame", d.worst},
                 {"picture", d.picture.string()}});
  return j;
}

nlohmann::json healed_json(const std::vector<pipeline::HealedCamera>& healed) {
  nlohmann::json j = nlohmann::json::array();
  for (const pipeline::HealedCamera& camera : healed)
    j.push_back({{"camera", camera.serial},
                 {"frames", camera.frames},
                 {"worst_frame", camera.worst},
                 {"lost", camera.lost},
                 {"gained", camera.gained}});
  return j;
}

Result<void> check_trusted(const std::filesystem::path& take,
                           const std::vector<pipeline::MatteDoubt>& doubts) {
  if (doubts.empty()) return {};
  std::set<std::string> cameras;
  for (const pipeline::MatteDoubt& d : doubts) cameras.insert(d.cameras.begin(), d.cameras.end());
  return fail(ErrorCode::BadData,
              text("the mattes of ", cameras.size(), cameras.size() == 1 ? " camera" : " cameras",
                   " are not to be trusted (above); look at the pictures in ",
                   pipeline::doubts_folder(TakeLayout(take)).string()));
}

}  // namespace floatstage::apps
