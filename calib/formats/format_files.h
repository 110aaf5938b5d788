#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/rig_formats.h"

namespace floatstage::calib {

/// Each format's reader and writer of named files. Outside of calib/formats the table of rig_formats.h is
/// what knows of them; tests call them by themselves.

/// Middlebury multi-view `*_par.txt`: count, then name, K (3×3), R (3×3), t a line; pixel centres at
/// integers.
Result<ForeignRig> read_middlebury(const std::filesystem::path& par_txt);
/// COLMAP's model: a folder with cameras.bin and images.bin, or cameras.txt and images.txt; the binary files
/// where there are both, as COLMAP does. Corner convention like ours.
Result<ForeignRig> read_colmap(const std::filesystem::path& folder);
/// transforms.json of nerfstudio and instant-ngp; the origin of pixels is the corner.
Result<ForeignRig> read_transforms(const std::filesystem::path& file);
/// OpenMVG's sfm_data.json; pixel centres at integers.
Result<ForeignRig> read_openmvg(const std::filesystem::path& file);
/// A scene of MVE: its folder, or views/ in it, with a folder *.mve a view. The origin of pixels is the
/// corner.
Result<ForeignRig> read_mve(const std::filesystem::path& scene);
/// Whether there is such a view.
bool is_mve(const std::filesystem::path& scene);
/// calibration_*.json of the CMU Panoptic Studio; centimetres, pixel centres at integers.
Result<ForeignRig> read_panoptic(const std::filesystem::path& file);
/// OpenCV/EasyMocap: a folder with intri.yml and extri.yml; pixel centres at integers.
Result<ForeignRig> read_easymocap(const std::filesystem::path& folder);
/// Qualisys `.qca.txt` (XML, millimetres, units of 1/64 px).
Result<ForeignRig> read_qualisys(const std::filesystem::path& qca_txt);
/// The plain text of the green dome: index; K; k1 k2; R|t, blank line; pixel centres at integers.
/// `metres_per_unit` scales its translations (its unit is not stated; about a decimetre).
Result<ForeignRig> read_dome(const std::filesystem::path& calibration_txt, double metres_per_unit);
/// Kalibr's camchain YAML: pinhole cameras with radtan, equidistant or no distortion; pixel centres at
/// integers. The world is the first camera's frame.
Result<ForeignRig> read_kalibr(const std::filesystem::path& camchain_yaml);

/// A light field's pictures, in the folder or in views/ below it, whose names say where each was taken:
/// NAME_<row>_<column>_<y mm>_<x mm>_<focal length mm>_<sensor width mm>.jpg or .png.
Result<ForeignRig> read_lightfield(const std::filesystem::path& folder);
/// Whether there is such a picture.
bool names_a_lightfield(const std::filesystem::path& folder);

/// The same formats written, so that others' tools open our rigs. Writers refuse what a format cannot hold.
Result<void> write_middlebury(const Rig& rig, const std::vector<std::string>& image_names,
                              const std::filesystem::path& par_txt);
Result<void> write_colmap(const Rig& rig, const std::vector<std::string>& image_names,
                          const std::filesystem::path& folder);
Result<void> write_easymocap(const Rig& rig, const std::filesystem::path& folder);
/// Only relative to its first camera: a camchain has no world. Serials stand in the topics.
Result<void> write_kalibr(const Rig& rig, const std::filesystem::path& camchain_yaml);
Result<void> write_qualisys(const Rig& rig, const std::filesystem::path& qca_txt);

}  // namespace floatstage::calib
