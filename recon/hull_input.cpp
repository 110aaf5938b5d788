#include "recon/hull_input.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/text.h"
#include "recon/bounding_volume.h"
#include "recon/outline.h"

namespace floatstage::recon {
namespace {

constexpr std::size_t kMostPoints = 20000;  // of one outline, as SilhouetteOptions::most_points

/// Empty, or what is wrong with an outline.
std::string flaw(const Silhouette& outline, const CameraModel& model, PolygonBounds& memory) {
  const auto& starts = outline.starts;
  if (outline.points.empty() && starts.size() <= 1) return {};
  if (starts.size() < 2 || starts.front() != 0 || starts.back() != static_cast<int>(outline.points.size()))
    return "its polygons do not share out its points";
  for (std::size_t k = 0; k + 1 < starts.size(); ++k) {
    if (starts[k + 1] < starts[k] + 3) return "one of its polygons has fewer than three points";
  }
  if (outline.points.size() > kMostPoints)
    return text("it has ", outline.points.size(), " points, more than ", kMostPoints);
  const double reach = std::max(model.width, model.height);
  for (const Eigen::Vector2d& p : outline.points) {
    if (!(p.x() >= -reach && p.y() >= -reach && p.x() <= 2 * reach && p.y() <= 2 * reach))
      return "it has points far outside the picture";
  }
  if (!tells_sides(outline, memory))
    return "its polygons do not tell subject from background: subject has to be right of every edge";
  return {};
}

}  // namespace

Result<void> HullInput::check(PolygonBounds& memory) const {
  if (count_ != rig_.cameras.size())
    return fail(ErrorCode::InvalidArgument,
                text(count_, outlines_.empty() ? " mattes" : " outlines", " for ", rig_.cameras.size(),
                     " cameras; give one each, empty where there is none"));
  for (std::size_t c = 0; c < mattes_.size(); ++c) {
    const CameraModel& model = rig_.cameras[c].model;
    const Matte& matte = mattes_[c];
    if (matte.empty() || (matte.width == model.width && matte.height == model.height)) continue;
    return fail(ErrorCode::InvalidArgument,
                text("camera '", rig_.cameras[c].serial, "': its matte is ", matte.width, "x", matte.height,
                     ", its images are ", model.width, "x", model.height,
                     "; key the images the rig was calibrated for"));
  }
  for (std::size_t c = 0; c < outlines_.size(); ++c) {
    const std::string what = flaw(outlines_[c], rig_.cameras[c].model, memory);
    if (what.empty()) continue;
    return fail(ErrorCode::BadData, text("camera '", rig_.cameras[c].serial, "': its outline is of no use: ",
                                         what, "; leave it out, and look at what sends it"));
  }
  return {};
}

bool HullInput::knows(std::size_t camera) const {
  if (outlines_.empty()) return !mattes_[camera].empty();
  return !outlines_[camera].empty() || outlines_[camera].beyond_counts;
}

bool HullInput::shows_subject(std::size_t camera) const {
  if (outlines_.empty()) return has_subject(mattes_[camera]);
  const Silhouette& outline = outlines_[camera];
  if (!outline.beyond_counts || outline.empty()) return knows(camera);
  // Where the border is traced through the middles of pixel sides, the four corners are cut: half a pixel.
  const double picture =
      static_cast<double>(rig_.cameras[camera].model.width) * rig_.cameras[camera].model.height;
  return outline.polygons() > 1 || picture + enclosed_area(outline) > 1;
}

std::span<const Matte> HullInput::mattes() {
  if (outlines_.empty()) return mattes_;
  if (filled_.empty()) {
    filled_.resize(outlines_.size());
    parallel_for(outlines_.size(), threads_, [&](std::size_t c) {
      filled_[c] = filled(outlines_[c], rig_.cameras[c].model.width, rig_.cameras[c].model.height);
    });
  }
  return filled_;
}

}  // namespace floatstage::recon
