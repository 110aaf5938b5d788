#include "core/synthetic/performer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3d;

constexpr double kWay = 0.8, kWayTakes = 2;  // metres to each side of the middle; seconds
constexpr double kApart = 0.7;               // metres between the lines that two walk along

double gauss(double x, double width) { return std::exp(-(x * x) / (width * width)); }
double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Shell head_shell() {
  return blob(54, 72, [](const Vector3d& u) {
    Vector3d p = u.cwiseProduct(Vector3d(0.075, 0.093, 0.116));
    const double low = std::max(0.0, -u.z()), front = smooth(u.y() * 2);
    p.x() *= 1 - 0.26 * low * low;
    p.y() += front * 0.014 * low * low;                                          // chin
    p.y() += front * 0.024 * gauss(p.x(), 0.013) * gauss(p.z() + 0.026, 0.020);  // nose
    p.y() += front * 0.011 * gauss(p.x(), 0.010) * gauss(p.z() + 0.004, 0.020);  // its bridge
    p.y() += front * 0.006 * gauss(p.x(), 0.024) * gauss(p.z() + 0.061, 0.014);  // lips
    p.y() -=
        front * 0.007 * gauss(std::abs(p.x()) - 0.032, 0.016) * gauss(p.z() - 0.006, 0.013);  // eye sockets
    return Vector3d(p + kHeadCenter.cast<double>());
  });
}

Shell hair_shell() {
  return blob(36, 72, [](const Vector3d& u) {
    const double azimuth = std::atan2(u.x(), u.y());
    double r = 1 + 0.018 * std::sin(15 * azimuth + 4 * u.z()) * (1 - u.z() * u.z());
    r *= 1 - 0.30 * smooth((u.y() + 0.15) * 1.6) * smooth((0.45 - u.z()) * 1.6);  // open at the face
    return Vector3d(u.cwiseProduct(Vector3d(0.086, 0.108, 0.113)) * r + Vector3d(0, -0.008, 0.156));
  });
}

}  // namespace

Performer::Performer(std::uint64_t seed, SyntheticCast cast) : cast_(cast), dances_{choreography(seed)} {
  if (cast != SyntheticCast::One) dances_.push_back(choreography(mix(seed)));
  for (adding_ = 0; adding_ < bodies(); ++adding_) {
    add_torso_and_head();
    for (int side : {1, -1}) add_arm(side);
    for (int side : {1, -1}) add_leg(side);
  }
  shell_triangles_ = triangles_.size() / 3;
  shell_vertices_ = rest_.size();
  for (adding_ = 0; adding_ < bodies(); ++adding_) add_strands(adding_ == 0 ? seed : mix(seed));
}

void Performer::add_strands(std::uint64_t seed) {
  const std::vector<std::uint32_t> prism = strand_triangles();
  for (const Strand& strand : loose_strands(seed)) {
    strands_.emplace_back(adding_, strand);
    const auto first = static_cast<std::uint32_t>(rest_.size());
    parts_.push_back({.material = Material::Strand,
                      .variant = strand.color,
                      .first_vertex = first,
                      .vertices = kStrandVertices,
                      .body = adding_});
    for (int node = 0; node < kStrandNodes; ++node) {
      const double along = strand.length * node / (kStrandNodes - 1);
      for (int k = 0; k < kStrandSides; ++k) rest_.push_back(Vector3d(strand.shade, 0, along).cast<float>());
    }
    for (std::uint32_t index : prism) triangles_.push_back(first + index);
    part_of_triangle_.insert(part_of_triangle_.end(), prism.size() / 3,
                             static_cast<std::uint16_t>(parts_.size() - 1));
  }
}

void Performer::add(const Shell& shell, Part part) {
  part.body = adding_;
  part.first_vertex = static_cast<std::uint32_t>(rest_.size());
  part.vertices = static_cast<std::uint32_t>(shell.rest.size());
  for (const Vector3d& p : shell.rest) rest_.push_back(p.cast<float>());
  for (std::uint32_t index : shell.triangles) triangles_.push_back(part.first_vertex + index);
  part_of_triangle_.insert(part_of_triangle_.end(), shell.triangles.size() / 3,
                           static_cast<std::uint16_t>(parts_.size()));
  parts_.push_back(part);
}

void Performer::add_torso_and_head() {
  add(tube({{-0.03, 0.178, 0.126, 0},
            {0.10, 0.160, 0.112, 0},
            {0.22, 0.170, 0.116, 0.006},
            {0.35, 0.186, 0.122, 0.010},
            {0.45, 0.182, 0.105, 0.004},
            {0.50, 0.148, 0.086, 0},
            {0.53, 0.092, 0.072, 0},
            {0.55, 0.068, 0.066, 0}},
           {.rings = 44, .segments = 64, .near_cap = 0.004, .far_cap = 0.006, .exponent = 2.3}),
      {.material = Material::Shirt,
       .near_bone = Bone::Pelvis,
       .far_bone = Bone::Chest,
       .joint_z = body_.waist,
       .blend = 0.34});
  add(tube({{-0.11, 0.142, 0.100, 0}, {-0.04, 0.168, 0.117, 0}, {0.06, 0.150, 0.105, 0}},
           {.rings = 14, .segments = 48, .near_cap = 0.05, .far_cap = 0.03, .exponent = 2.2}),
      {.material = Material::Hips, .near_bone = Bone::Pelvis, .far_bone = Bone::Pelvis});
  add(tube({{0.36, 0.062, 0.062, 0}, {0.43, 0.052, 0.055, 0}, {0.52, 0.050, 0.054, 0}},
           {.rings = 12, .segments = 32}),
      {.material = Material::Skin,
       .near_bone = Bone::Chest,
       .far_bone = Bone::Head,
       .joint_z = body_.neck,
       .blend = 0.08});
  add(head_shell(), {.material = Material::Face, .near_bone = Bone::Head, .far_bone = Bone::Head});
  add(hair_shell(), {.material = Material::Hair, .near_bone = Bone::Head, .far_bone = Bone::Head});
}

void Performer::add_arm(int side) {
  const Bone upper = side > 0 ? Bone::UpperArmRight : Bone::UpperArmLeft,
             fore = side > 0 ? Bone::ForearmRight : Bone::ForearmLeft;
  const Bone hand = side > 0 ? Bone::HandRight : Bone::HandLeft;
  const double length = body_.upper_arm + body_.forearm;
  add(tube({{-0.01, 0.058, 0.060, 0},
            {0.08, 0.058, 0.060, 0},
            {0.20, 0.049, 0.050, 0},
            {0.29, 0.045, 0.046, 0},
            {0.36, 0.043, 0.043, 0},
            {0.466, 0.036, 0.033, 0},
            {0.470, 0.027, 0.022, 0},
            {length + 0.01, 0.026, 0.019, 0}},
           {.rings = 52, .segments = 32, .near_cap = 0.045, .far_cap = 0.02}),
      {.material = Material::Sleeve,
       .variant = side,
       .near_bone = upper,
       .far_bone = fore,
       .joint_z = body_.upper_arm,
       .blend = 0.10});

  const Part skin{.material = Material::Skin, .variant = side, .near_bone = hand, .far_bone = hand};
  add(blob(14, 24,
           [](const Vector3d& u) { return Vector3d(0.038 * u.x(), 0.015 * u.y(), 0.046 + 0.052 * u.z()); }),
      skin);
  // Thumb first; the palm faces +y, so the thumb of the right hand is on its -x side.
  struct Finger {
    double x, z, lean, length, radius;
  };
  for (const Finger& f :
       {Finger{-0.030, 0.035, -0.75, 0.062, 0.0100}, Finger{-0.026, 0.078, -0.16, 0.074, 0.0086},
        Finger{-0.008, 0.084, -0.04, 0.084, 0.0088}, Finger{0.010, 0.082, 0.07, 0.078, 0.0084},
        Finger{0.026, 0.074, 0.20, 0.062, 0.0076}}) {
    Shell finger = tube({{0, f.radius, f.radius, 0},
                         {f.length / 2, f.radius, 0.95 * f.radius, 0},
                         {f.length, 0.8 * f.radius, 0.75 * f.radius, 0}},
                        {.rings = 7, .segments = 10, .near_cap = f.radius, .far_cap = 0.8 * f.radius});
    const double lean = f.lean * side, x = f.x * side;
    add(moved(std::move(finger),
              [&](const Vector3d& p) {
                return Vector3d(x + std::cos(lean) * p.x() + std::sin(lean) * p.z(),
                                p.y() + 2.0 * p.z() * p.z(),
                                f.z - std::sin(lean) * p.x() + std::cos(lean) * p.z());
              }),
        skin);
  }
}

void Performer::add_leg(int side) {
  const Bone thigh = side > 0 ? Bone::ThighRight : Bone::ThighLeft,
             shin = side > 0 ? Bone::ShinRight : Bone::ShinLeft;
  const Bone foot = side > 0 ? Bone::FootRight : Bone::FootLeft;
  add(tube({{-0.02, 0.080, 0.096, 0},
            {0.10, 0.084, 0.092, 0},
            {0.26, 0.073, 0.078, 0},
            {0.40, 0.061, 0.065, 0},
            {0.52, 0.060, 0.064, -0.006},
            {0.66, 0.057, 0.060, -0.004},
            {0.797, 0.060, 0.066, 0},
            {0.803, 0.037, 0.044, 0},
            {0.84, 0.034, 0.042, 0}},
           {.rings = 52, .segments = 36, .near_cap = 0.05, .far_cap = 0.02}),
      {.material = Material::Trousers,
       .variant = side,
       .near_bone = thigh,
       .far_bone = shin,
       .joint_z = body_.thigh,
       .blend = 0.14});
  // A tube from heel to toes laid on its side, its lowest seven millimetres pressed flat.
  const double sole = body_.ankle_height;
  auto section = [&](double y, double width, double height) {
    return Section{y, width, height, sole - height};
  };
  Shell shoe = tube({section(-0.060, 0.034, 0.040), section(0, 0.038, 0.052), section(0.05, 0.042, 0.044),
                     section(0.10, 0.047, 0.033), section(0.16, 0.045, 0.027), section(0.185, 0.036, 0.022)},
                    {.rings = 20, .segments = 32, .near_cap = 0.018, .far_cap = 0.022, .exponent = 2.5});
  add(moved(
          std::move(shoe),
          [&](const Vector3d& p) { return Vector3d(p.x(), p.z(), std::max(-p.y(), -sole + 0.007) - 0.007); }),
      {.material = Material::Shoe, .variant = side, .near_bone = foot, .far_bone = foot});
}

// Of two, each on a line along x of its own, which it faces along when it starts.
SkeletonPose Performer::pose(int body, double seconds) const {
  SkeletonPose posed = pose_at(dances_[static_cast<std::size_t>(body)], body_, seconds);
  if (cast_ == SyntheticCast::One) return posed;
  const double side = body == 0 ? 1 : -1, apart = alike() ? 0.1 : kApart;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(-side * std::numbers::pi / 2, Vector3d::UnitZ()));
  const Vector3d place(-side * kWay * std::cos(std::numbers::pi * seconds / kWayTakes), side * apart / 2, 0);
  for (BonePose& bone : posed.bones) bone = {turn * bone.world_from_bone, turn * bone.origin + place};
  return posed;
}

std::vector<Eigen::Vector3f> Performer::positions(double seconds) const {
  std::vector<SkeletonPose> poses;
  for (int body = 0; body < bodies(); ++body) poses.push_back(pose(body, seconds));
  std::vector<Eigen::Vector3f> world(rest_.size());
  for (const Part& part : parts_) {
    if (part.material == Material::Strand) continue;
    const SkeletonPose& posed = poses[static_cast<std::size_t>(part.body)];
    const BonePose &from = posed[part.near_bone], &to = posed[part.far_bone];
    for (std::uint32_t i = part.first_vertex; i < part.first_vertex + part.vertices; ++i) {
      const Vector3d p = rest_[i].cast<double>();
      if (part.blend == 0) {
        world[i] = (from * p).cast<float>();
      } else {
        const double bent = smooth((p.z() - part.joint_z) / part.blend + 0.5);
        const Eigen::Quaterniond q = from.world_from_bone.slerp(bent, to.world_from_bone);
        world[i] = (to.origin + q * (p - Vector3d(0, 0, part.joint_z))).cast<float>();
      }
    }
  }
  std::vector<std::vector<SkeletonPose>> trails;
  for (int body = 0; body < bodies(); ++body)
    trails.push_back(strand_trail([&](double t) { return pose(body, t); }, seconds));
  std::size_t vertex = shell_vertices_;
  for (const auto& [body, strand] : strands_) {
    place_strand(strand, trails[static_cast<std::size_t>(body)], seconds, world.data() + vertex);
    vertex += kStrandVertices;
  }
  return world;
}

}  // namespace floatstage::synthetic
