#include <cmath>

#include "calib/formats/camera_parts.h"
#include "calib/formats/format_files.h"
#include "calib/formats/text_lines.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {

Result<void> write_qualisys(const Rig& rig, const std::filesystem::path& qca_txt) {
  constexpr double kUnitsPerPixel = 64, kUnitsPerMetre = 1000;
  const std::string file = qca_txt.string();
  if (Result<void> ok = check(rig); !ok) return fail(ok.error().code, text(file, ": ", ok.error().message));
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<calibration>\n  <cameras>\n";
  for (const RigCamera& c : rig.cameras) {
    if (std::holds_alternative<KannalaBrandt>(c.model.lens))
      return fail(ErrorCode::Unsupported,
                  text(file, ": camera '", c.serial,
                       "' has a fisheye lens, which this format cannot hold; write COLMAP instead"));
    const auto* brown = std::get_if<BrownConrady>(&c.model.lens);
    if (brown && brown->rational())
      return fail(
          ErrorCode::Unsupported,
          text(file, ": camera '", c.serial,
               "' has a rational lens, which this format cannot hold; write COLMAP or OpenCV instead"));
    const BrownConrady d = brown ? *brown : BrownConrady{};
    const Eigen::Matrix3d k = kUnitsPerPixel * k_with_origin(c.model, PixelOrigin::FirstPixelCenter);
    // Its axes: y up, z backwards. Half a turn about x from ours.
    Eigen::Matrix3d axes = c.cam_from_world.rotation.toRotationMatrix();
    axes.bottomRows<2>() *= -1;
    const Eigen::Vector3d center = kUnitsPerMetre * c.cam_from_world.center();
    out += text("    <camera active=\"1\" serial=\"", c.serial,
                "\">\n      <fov_video left=\"0\" top=\"0\" right=\"", c.model.width - 1, "\" bottom=\"",
                c.model.height - 1, "\"/>\n      <transform x=\"", to_text(center.x()), "\" y=\"",
                to_text(center.y()), "\" z=\"", to_text(center.z()), '"');
    for (int r = 0; r < 3; ++r)
      for (int col = 0; col < 3; ++col) out += text(" r", r + 1, col + 1, "=\"", to_text(axes(r, col)), '"');
    out +=
        text("/>\n      <intrinsic focalLengthU=\"", to_text(k(0, 0)), "\" focalLengthV=\"", to_text(k(1, 1)),
             "\" centerPointU=\"", to_text(k(0, 2)), "\" centerPointV=\"", to_text(k(1, 2)), "\" skew=\"",
             to_text(k(0, 1)), "\" radialDistortion1=\"", to_text(d.k1), "\" radialDistortion2=\"",
             to_text(d.k2), "\" radialDistortion3=\"", to_text(d.k3), "\" tangentalDistortion1=\"",
             to_text(d.p1), "\" tangentalDistortion2=\"", to_text(d.p2), "\"/>\n    </camera>\n");
  }
  return write_file(qca_txt, out + "  </cameras>\n</calibration>\n");
}

}  // namespace floatstage::calib
