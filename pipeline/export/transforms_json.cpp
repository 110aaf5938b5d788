#include "pipeline/export/transforms_json.h"

#include <nlohmann/json.hpp>

#include "core/check.h"

namespace floatstage::pipeline {

std::string transforms_json(const Rig& rig, const PicturePaths& paths) {
  FLOATSTAGE_CHECK(paths.pictures.size() == rig.cameras.size() && paths.mattes.size() == rig.cameras.size(),
                   "not one picture a camera");
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const CameraModel& m = rig.cameras[i].model;
    Eigen::Matrix4d world_from_camera = rig.cameras[i].cam_from_world.inverse().matrix();
    world_from_camera.middleCols<2>(1) *= -1;  // y up, z backward
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (int r = 0; r < 4; ++r) {
      const Eigen::RowVector4d row = world_from_camera.row(r);
      rows.push_back({row[0], row[1], row[2], row[3]});
    }
    nlohmann::ordered_json frame = {{"file_path", paths.pictures[i]}};
    if (!paths.mattes[i].empty()) frame["mask_path"] = paths.mattes[i];
    for (const auto& [key, value] : {std::pair{"fl_x", m.fx}, {"fl_y", m.fy}, {"cx", m.cx}, {"cy", m.cy}})
      frame[key] = value;
    frame["w"] = m.width;
    frame["h"] = m.height;
    frame["transform_matrix"] = std::move(rows);
    frames.push_back(std::move(frame));
  }
  const nlohmann::ordered_json all = {
      {"camera_model", "PINHOLE"}, {"ply_file_path", paths.points}, {"frames", std::move(frames)}};
  return all.dump(1) + "\n";
}

}  // namespace floatstage::pipeline
