#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/rig_formats.h"

namespace floatstage::calib {

/// The readers of format_files.h on text in memory: what tests and fuzzers call. `name` stands in messages.

Result<ForeignRig> parse_middlebury(std::string_view text, std::string_view name);
Result<ForeignRig> parse_dome(std::string_view text, double metres_per_unit, std::string_view name);
Result<ForeignRig> parse_colmap(std::string_view cameras, std::string_view images,
                                std::string_view cameras_name, std::string_view images_name);
Result<ForeignRig> parse_colmap_binary(std::string_view cameras, std::string_view images,
                                       std::string_view cameras_name, std::string_view images_name);
/// How large a picture is that a file names without saying so: width and height.
using PictureSize = std::function<Result<std::pair<int, int>>(const std::string& picture)>;
Result<ForeignRig> parse_transforms(std::string_view json, const PictureSize& size_of, std::string_view name);
Result<ForeignRig> parse_openmvg(std::string_view json, std::string_view name);
/// One view of an MVE scene: its folder's name, its meta.ini, and the picture of it that is taken.
struct MveView {
  std::string folder;         ///< "view_0000.mve"
  std::string meta;           ///< what is in its meta.ini
  std::string picture;        ///< "undistorted.png"; empty: it has none
  bool straight = true;       ///< an undistorted picture; false: the original, whose lens meta.ini must state
  int width = 0, height = 0;  ///< px, of the picture
};
/// Views without a camera are left out.
Result<ForeignRig> parse_mve(const std::vector<MveView>& views, std::string_view name);
Result<ForeignRig> parse_panoptic(std::string_view json, std::string_view name);
Result<ForeignRig> parse_easymocap(std::string_view intri, std::string_view extri,
                                   std::string_view intri_name, std::string_view extri_name);
Result<ForeignRig> parse_kalibr(std::string_view yaml, std::string_view name);
Result<ForeignRig> parse_qualisys(std::string_view xml, std::string_view name);
/// `names` of pictures of width x height px.
Result<ForeignRig> parse_lightfield(const std::vector<std::string>& names, int width, int height,
                                    std::string_view name_for_errors);

/// What every reader ends with: there is a camera, and no two have one serial.
Result<ForeignRig> checked(ForeignRig foreign, std::string_view name);

/// What every writer begins with: the rig is sound and has one image name a camera.
Result<void> check_writable(const Rig& rig, const std::vector<std::string>& image_names,
                            std::string_view name);

}  // namespace floatstage::calib
