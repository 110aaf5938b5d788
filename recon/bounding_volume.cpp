// Method:  a box around the intersection of the
//          silhouettes' bounding pyramids
// Paper:   none: half spaces cut a convex body, face by face
// Differs: what the border of a picture cuts does not bound on that side
// ADR:     none; docs/algorithms/visual-hull.md, section 1

#include "recon/bounding_volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

struct HalfSpace {
  Vector3d normal;  // points inside: normal · x + offset >= 0
  double offset;
};

// A convex body as its corners and faces would be needed to cut it again and again; since only the final box
// counts, faces as plain polygons do: cutting clips each polygon and closes the body with one more.
class ConvexBody {
 public:
  explicit ConvexBody(const Eigen::AlignedBox3d& box) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::vector<Vector3d> face;
        for (const auto& [su, sv] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
          Vector3d corner;
          corner[axis] = side ? box.max()[axis] : box.min()[axis];
          corner[u] = su ? box.max()[u] : box.min()[u];
          corner[v] = sv ? box.max()[v] : box.min()[v];
          face.push_back(corner);
        }
        faces_.push_back(std::move(face));
      }
    }
  }

  void cut(const HalfSpace& h) {
    auto height = [&](const Vector3d& p) { return h.normal.dot(p) + h.offset; };
    std::vector<Vector3d> cap;
    bool touched = false;
    for (std::vector<Vector3d>& face : faces_) {
      std::vector<Vector3d> kept;
      for (std::size_t i = 0; i < face.size(); ++i) {
        const Vector3d &a = face[i], &b = face[(i + 1) % face.size()];
        const double ha = height(a), hb = height(b);
        if (ha >= 0) kept.push_back(a);
        touched |= ha < 0;
        if ((ha >= 0) == (hb >= 0)) continue;
        const Vector3d crossing = a + (b - a) * (ha / (ha - hb));
        kept.push_back(crossing);
        cap.push_back(crossing);
      }
      face = kept.size() >= 3 ? std::move(kept) : std::vector<Vector3d>{};
    }
    std::erase_if(faces_, [](const auto& face) { return face.empty(); });
    if (touched && cap.size() >= 3) faces_.push_back(in_order(std::move(cap), h.normal));
  }

  Eigen::AlignedBox3d box() const {
    Eigen::AlignedBox3d b;
    for (const auto& face : faces_)
      for (const Vector3d& p : face) b.extend(p);
    return b;
  }

 private:
  // The corners of a convex polygon in a plane, sorted around their middle.
  static std::vector<Vector3d> in_order(std::vector<Vector3d> corners, const Vector3d& normal) {
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& p : corners) middle += p / static_cast<double>(corners.size());
    const Vector3d u = normal.unitOrthogonal(), v = normal.normalized().cross(u);
    auto angle = [&](const Vector3d& p) { return std::atan2((p - middle).dot(v), (p - middle).dot(u)); };
    std::sort(corners.begin(), corners.end(),
              [&](const Vector3d& a, const Vector3d& b) { return angle(a) < angle(b); });
    return corners;
  }

  std::vector<std::vector<Vector3d>> faces_;
};

struct Sides {
  bool left, right, top, bottom;
};

// Which sides of the subject's rectangle bound it in space.
Sides bounding_sides(const Eigen::AlignedBox2i& r, const Matte& m, bool give_up_outside) {
  const bool left = r.min().x() == 0, right = r.max().x() == m.width - 1;
  const bool top = r.min().y() == 0, bottom = r.max().y() == m.height - 1;
  if (give_up_outside) {
    const bool some_side_is_free = !(left && right && top && bottom);
    return {some_side_is_free, some_side_is_free, some_side_is_free, some_side_is_free};
  }
  return {!left && !top && !bottom, !right && !top && !bottom, !top && !left && !right,
          !bottom && !left && !right};
}

// The pyramid's planes: sides of the rectangle in normalised coordinates that holds the lens-free outline of
// `r`.
void add_planes(const RigCamera& camera, const Matte& matte, bool give_up_outside,
                std::vector<HalfSpace>& planes) {
  const Eigen::AlignedBox2i r = subject_rectangle(matte);
  if (r.isEmpty()) return;
  // Half a pixel more: bilinear mattes cross half opacity up to there.
  const Eigen::AlignedBox2d outline(r.min().cast<double>().array() - 0.5,
                                    r.max().cast<double>().array() + 1.5);
  Eigen::AlignedBox2d normalized;
  constexpr int kSteps = 64;  // a lens bends the sides; they are followed
  for (int i = 0; i <= kSteps; ++i) {
    const Eigen::Vector2d p = outline.min() + outline.sizes() * (static_cast<double>(i) / kSteps);
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(p.x(), outline.min().y()), Eigen::Vector2d(p.x(), outline.max().y()),
          Eigen::Vector2d(outline.min().x(), p.y()), Eigen::Vector2d(outline.max().x(), p.y())}) {
      const std::optional<Vector3d> ray = unproject(camera.model, pixel);
      if (!ray) return;  // beyond the lens: this camera cannot bound its subject
      normalized.extend(ray->head<2>());
    }
  }
  const Sides sides = bounding_sides(r, matte, give_up_outside);
  const Rigid3& t = camera.cam_from_world;
  auto add = [&](bool wanted, const Vector3d& in_camera) {
    if (wanted) planes.push_back({t.rotation.conjugate() * in_camera, in_camera.dot(t.translation)});
  };
  add(sides.left, {1, 0, -normalized.min().x()});
  add(sides.right, {-1, 0, normalized.max().x()});
  add(sides.top, {0, 1, -normalized.min().y()});
  add(sides.bottom, {0, -1, normalized.max().y()});
  // Two opposite planes already meet in the camera; a single one needs to be told which side is in front.
  add(sides.left || sides.right || sides.top || sides.bottom, Vector3d::UnitZ());
}

/// The first pixel of a row with alpha >= 128, or the width. Eight pixels at a time: mattes are mostly empty.
int first_subject(const std::uint8_t* row, int width) {
  int x = 0;
  for (; x + 8 <= width; x += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, row + x, 8);
    if ((eight & 0x8080808080808080ULL) != 0) break;
  }
  while (x < width && row[x] < 128) ++x;
  return x;
}

}  // namespace

bool has_subject(const Matte& matte) {
  if (matte.empty()) return false;
  for (int y = 0; y < matte.height; ++y) {
    if (first_subject(matte.row(y), matte.width) < matte.width) return true;
  }
  return false;
}

Eigen::AlignedBox2i subject_rectangle(const Matte& matte) {
  Eigen::AlignedBox2i box;
  if (matte.empty()) return box;
  for (int y = 0; y < matte.height; ++y) {
    const std::uint8_t* row = matte.row(y);
    const std::uint8_t* first = row + first_subject(row, matte.width);
    if (first == row + matte.width) continue;
    const std::uint8_t* last = row + matte.width - 1;
    while (*last < 128) --last;
    box.extend(Eigen::Vector2i(static_cast<int>(first - row), y));
    box.extend(Eigen::Vector2i(static_cast<int>(last - row), y));
  }
  return box;
}

std::optional<Eigen::AlignedBox3d> bounding_volume(const Rig& rig, std::span<const Matte> mattes) {
  Eigen::AlignedBox3d centers;
  for (const RigCamera& c : rig.cameras) centers.extend(c.cam_from_world.center());
  // Everything the rig could be about lies within a hundred times its own size; what reaches further is
  // unbounded.
  const double reach = 100 * std::max(centers.diagonal().norm(), 1e-3);
  const Eigen::AlignedBox3d everything(centers.center() - Vector3d::Constant(reach),
                                       centers.center() + Vector3d::Constant(reach));
  for (bool give_up_outside : {false, true}) {
    std::vector<HalfSpace> planes;
    for (std::size_t i = 0; i < rig.cameras.size(); ++i)
      if (!mattes[i].empty()) add_planes(rig.cameras[i], mattes[i], give_up_outside, planes);
    ConvexBody body(everything);
    for (const HalfSpace& plane : planes) body.cut(plane);
    const Eigen::AlignedBox3d box = body.box();
    if (box.isEmpty()) return box;
    const Vector3d slack = Vector3d::Constant(1e-9 * reach);
    if ((box.min().array() > (everything.min() + slack).array()).all() &&
        (box.max().array() < (everything.max() - slack).array()).all())
      return box;
  }
  return std::nullopt;
}

}  // namespace floatstage::recon
