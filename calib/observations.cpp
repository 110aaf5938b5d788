#include "calib/observations.h"

#include <cmath>
#include <set>
#include <tuple>

#include "core/text.h"

namespace floatstage::calib {
namespace {

Unexpected bad(const std::string& sentence) { return fail(ErrorCode::BadData, sentence); }

bool is_rotation(const Rigid3& t) {
  return t.rotation.coeffs().allFinite() && std::abs(t.rotation.norm() - 1) < 1e-6 &&
         t.translation.allFinite();
}

bool fits(const Lens& lens, LensKind kind) {
  return lens.index() == 0 || lens.index() == static_cast<std::size_t>(kind);
}

Result<void> check_camera(const CalibrationCamera& c) {
  if (!is_usable_serial(c.serial))
    return bad(text("camera '", c.serial, "': a serial has letters, digits, '.', '_' and '-' only"));
  if (c.width <= 0 || c.height <= 0)
    return bad(
        text("camera '", c.serial, "': its picture's size ", c.width, "x", c.height, " is not positive"));
  if (c.intrinsics != Prior::Unknown) {
    if (Result<void> ok = check(c.model); !ok)
      return bad(text("camera '", c.serial, "': ", ok.error().message));
    if (c.model.width != c.width || c.model.height != c.height)
      return bad(text("camera '", c.serial, "': its intrinsics are for ", c.model.width, "x", c.model.height,
                      ", its pictures have ", c.width, "x", c.height, "; scale them or leave them out"));
    if (!fits(c.model.lens, c.lens))
      return bad(text("camera '", c.serial, "': its known lens is of another kind than the one to be found"));
  }
  if (c.pose != Prior::Unknown && !is_rotation(c.cam_from_world))
    return bad(text("camera '", c.serial, "': its known pose is not a rotation and a translation"));
  if (c.found && !is_rotation(*c.found))
    return bad(text("camera '", c.serial, "': the place found for it is not a rotation and a translation"));
  return {};
}

Result<void> check_target(const Target& t) {
  std::set<int> ids;
  for (const TargetPoint& p : t.points) {
    if (p.id < 0 || !ids.insert(p.id).second)
      return bad(text("target '", t.name, "': point id ", p.id, " is negative or stands there twice"));
    const bool surface = p.normal.isZero() || std::abs(p.normal.norm() - 1) < 1e-6;
    if (!p.position.allFinite() || !surface)
      return bad(
          text("target '", t.name, "': point ", p.id, " has no finite position or no normal of unit length"));
  }
  if (t.points.empty()) return bad(text("target '", t.name, "' has no points"));
  for (const TargetLength& l : t.lengths)
    if (l.a == l.b || !ids.contains(l.a) || !ids.contains(l.b) || !(l.metres > 0) ||
        !std::isfinite(l.metres) || !(l.sigma > 0) || !std::isfinite(l.sigma))
      return bad(text("target '", t.name, "': the length between points ", l.a, " and ", l.b,
                      " is not between two of its points, or it or its sigma is not positive"));
  if (t.kind == TargetKind::Wand && t.lengths.empty())
    return bad(
        text("target '", t.name, "' is a wand without lengths; give the distances between its markers"));
  if (t.positions_sigma && !(*t.positions_sigma > 0 && std::isfinite(*t.positions_sigma)))
    return bad(text("target '", t.name, "': the sigma of its positions is not positive"));
  if (t.grid && (t.grid->columns < 1 || t.grid->rows < 1 || t.grid->columns > 10'000 ||
                 t.grid->rows > 10'000 || !(t.grid->pitch > 0) || !std::isfinite(t.grid->pitch)))
    return bad(text("target '", t.name, "': its grid ", t.grid->columns, "x", t.grid->rows,
                    " has no positive size"));
  return {};
}

// Far outside of every picture: a detector's runaway, not a measurement.
constexpr double kFarthestPixel = 1e6;

Result<void> check_view(const TargetView& v, const Observations& o, const std::set<int>& ids) {
  const std::string where =
      text("camera '", o.cameras[static_cast<std::size_t>(v.camera)].serial, "', frame ", v.frame);
  std::set<int> seen;
  for (const SeenPoint& p : v.points) {
    if (!ids.contains(p.id)) {
      return bad(text(where, ": target '", o.targets[static_cast<std::size_t>(v.target)].name,
                      "' has no point ", p.id));
    }
    if (!seen.insert(p.id).second)
      return bad(text(where, ": point ", p.id, " was seen twice in one picture"));
    if (!p.pixel.allFinite() || p.pixel.cwiseAbs().maxCoeff() > kFarthestPixel)
      return bad(text(where, ": point ", p.id, " is at no finite pixel"));
    if (!(p.sigma > 0) || !std::isfinite(p.sigma))
      return bad(text(where, ": point ", p.id, " has the sigma ", p.sigma, " px, which is not positive"));
  }
  return {};
}

Result<void> check_lenses(const std::vector<CalibrationCamera>& cameras) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CalibrationCamera& c = cameras[i];
    if (!c.same_lens_as) continue;
    const int of = *c.same_lens_as;
    if (of < 0 || of >= static_cast<int>(i) || cameras[static_cast<std::size_t>(of)].same_lens_as)
      return bad(text("camera '", c.serial, "' has the lens of camera ", of,
                      ", which is not an earlier one with a lens of its own"));
    const CalibrationCamera& owner = cameras[static_cast<std::size_t>(of)];
    if (c.intrinsics == Prior::Unknown || c.intrinsics != owner.intrinsics || c.lens != owner.lens ||
        c.width != owner.width || c.height != owner.height || !(c.model == owner.model))
      return bad(text("cameras '", c.serial, "' and '", owner.serial,
                      "' share a lens, but begin from different intrinsics, or from none"));
  }
  return {};
}

}  // namespace

int point_index(const Target& target, int id) {
  // Detectors number points as they lie in the list; only odd targets need the search.
  const auto count = static_cast<int>(target.points.size());
  if (id >= 0 && id < count && target.points[static_cast<std::size_t>(id)].id == id) return id;
  for (int i = 0; i < count; ++i)
    if (target.points[static_cast<std::size_t>(i)].id == id) return i;
  return -1;
}

Result<void> check(const Observations& o) {
  std::set<std::string> serials, names;
  for (const CalibrationCamera& c : o.cameras) {
    if (Result<void> ok = check_camera(c); !ok) return ok;
    if (!serials.insert(c.serial).second) return bad(text("camera '", c.serial, "' stands there twice"));
  }
  if (Result<void> ok = check_lenses(o.cameras); !ok) return ok;
  std::vector<std::set<int>> ids;
  for (const Target& t : o.targets) {
    if (Result<void> ok = check_target(t); !ok) return ok;
    if (!names.insert(t.name).second) return bad(text("target '", t.name, "' stands there twice"));
    ids.emplace_back();
    for (const TargetPoint& p : t.points) ids.back().insert(p.id);
  }
  const auto cameras = static_cast<int>(o.cameras.size()), targets = static_cast<int>(o.targets.size());
  std::set<std::tuple<int, int, int>> views;
  for (std::size_t i = 0; i < o.views.size(); ++i) {
    const TargetView& v = o.views[i];
    if (v.camera < 0 || v.camera >= cameras || v.target < 0 || v.target >= targets)
      return bad(text("view ", i, " is of camera ", v.camera, " and target ", v.target, "; there are ",
                      cameras, " cameras and ", targets, " targets"));
    if (!views.emplace(v.camera, v.target, v.frame).second)
      return bad(text("camera '", o.cameras[static_cast<std::size_t>(v.camera)].serial, "' has frame ",
                      v.frame, " of target ", v.target, " twice"));
    if (Result<void> ok = check_view(v, o, ids[static_cast<std::size_t>(v.target)]); !ok) return ok;
  }
  for (const CameraDistance& d : o.distances)
    if (d.a < 0 || d.b < 0 || d.a >= cameras || d.b >= cameras || d.a == d.b || !(d.metres > 0) ||
        !std::isfinite(d.metres) || !(d.sigma > 0) || !std::isfinite(d.sigma))
      return bad(text("the distance between cameras ", d.a, " and ", d.b, " is not between two of the ",
                      cameras, " cameras, or it or its sigma is not positive"));
  if (const auto* floor = std::get_if<FloorBoard>(&o.gauge))
    if (floor->target < 0 || floor->target >= targets || !std::isfinite(floor->height) ||
        o.targets[static_cast<std::size_t>(floor->target)].kind != TargetKind::Board)
      return bad(
          text("the floor is set by target ", floor->target, ", which is not a board of this capture"));
  if (const auto* hand = std::get_if<HandSet>(&o.gauge))
    if (hand->camera < 0 || hand->camera >= cameras || !is_rotation(hand->cam_from_world))
      return bad(text("the world is set by camera ", hand->camera,
                      ", which is not one of this capture, or by no pose"));
  return {};
}

}  // namespace floatstage::calib
