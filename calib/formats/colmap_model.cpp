// COLMAP's sparse model as text and as binary files, which the programs of its neighbourhood read in turn:
// COLMAP 3.8 itself, and trainers of Gaussian splats, which want the points too. The binary layout is that of
// COLMAP's src/base/reconstruction.cc (little-endian, no padding).
#include "calib/colmap_model.h"

#include <array>
#include <bit>

#include "calib/formats/colmap_cameras.h"
#include "calib/formats/parsers.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

struct Files {
  std::string text, binary;
};

Files cameras_of(const Rig& rig) {
  Files f{"# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n", {}};
  put<std::uint64_t>(f.binary, rig.cameras.size());
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const CameraModel& m = rig.cameras[i].model;
    const ColmapCamera camera = camera_to_colmap(m);
    f.text += text(i + 1, ' ', camera.model->name, ' ', m.width, ' ', m.height);
    put(f.binary, static_cast<std::uint32_t>(i + 1));
    put(f.binary, camera.model->id);
    put(f.binary, static_cast<std::uint64_t>(m.width));
    put(f.binary, static_cast<std::uint64_t>(m.height));
    for (const double v : camera.parameters) {
      f.text += ' ' + to_text(v);
      put(f.binary, v);
    }
    f.text += '\n';
  }
  return f;
}

Files images_of(const Rig& rig, const std::vector<std::string>& names) {
  Files f{"# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points: X Y POINT3D_ID …\n", {}};
  put<std::uint64_t>(f.binary, rig.cameras.size());
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const Eigen::Quaterniond& q = rig.cameras[i].cam_from_world.rotation;
    const Eigen::Vector3d& t = rig.cameras[i].cam_from_world.translation;
    f.text += text(i + 1);
    put(f.binary, static_cast<std::uint32_t>(i + 1));
    for (const double v : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      f.text += ' ' + to_text(v);
      put(f.binary, v);
    }
    f.text += text(' ', i + 1, ' ', names[i], '\n');
    put(f.binary, static_cast<std::uint32_t>(i + 1));
    f.binary.append(names[i].c_str(), names[i].size() + 1);
    put<std::uint64_t>(f.binary, 0);
    f.text += '\n';
  }
  return f;
}

Files points_of(std::span<const ColmapPoint> points) {
  Files f{"# POINT3D_ID X Y Z R G B ERROR, then the track: IMAGE_ID POINT2D_IDX …\n", {}};
  put<std::uint64_t>(f.binary, points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    const ColmapPoint& point = points[p];
    f.text += text(p + 1);
    put<std::uint64_t>(f.binary, p + 1);
    for (int axis = 0; axis < 3; ++axis) {
      f.text += ' ' + to_text(point.position[axis]);
      put(f.binary, point.position[axis]);
    }
    for (const std::uint8_t c : point.color) {
      f.text += text(' ', static_cast<int>(c));
      put(f.binary, c);
    }
    f.text += " 0";
    put(f.binary, 0.0);
    put<std::uint64_t>(f.binary, 0);
    f.text += '\n';
  }
  return f;
}

}  // namespace

Result<void> write_colmap_model(const Rig& rig, const std::vector<std::string>& image_names,
                                std::span<const ColmapPoint> points, const std::filesystem::path& folder) {
  if (Result<void> ok = check_writable(rig, image_names, folder.string()); !ok) return ok;
  for (const RigCamera& camera : rig.cameras)
    if (camera.model.skew != 0)
      return fail(ErrorCode::Unsupported, text(folder.string(), ": camera '", camera.serial,
                                               "' has skewed pixels, which this format cannot hold"));
  if (Result<void> ok = make_folder(folder); !ok) return ok;
  const std::array<std::pair<const char*, Files>, 3> all{{{"cameras", cameras_of(rig)},
                                                          {"images", images_of(rig, image_names)},
                                                          {"points3D", points_of(points)}}};
  for (const auto& [name, files] : all) {
    if (Result<void> ok = write_file(folder / text(name, ".txt"), files.text); !ok) return ok;
    if (Result<void> ok = write_file(folder / text(name, ".bin"), files.binary); !ok) return ok;
  }
  return {};
}

}  // namespace floatstage::calib
