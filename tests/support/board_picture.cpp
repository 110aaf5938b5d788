#include "tests/support/board_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "calib/target_sheet.h"
#include "core/parallel.h"
#include "core/random.h"

namespace floatstage::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A sheet that can be asked for its grey at any place: shapes are sorted into buckets by their boxes.
class Paper {
 public:
  Paper(const calib::Sheet& sheet, const BoardPictureOptions& o)
      : sheet_(sheet), options_(o), buckets_(kAcross * kAcross) {
    for (std::size_t i = 0; i < sheet.inks.size(); ++i) {
      const calib::Ink& ink = sheet.inks[i];
      Vector2d low = ink.center.array() - ink.radius, high = ink.center.array() + ink.radius;
      if (ink.radius <= 0) {
        low.setConstant(1e9), high.setConstant(-1e9);
        for (const auto& loop : ink.loops)
          for (const Vector2d& p : loop) low = low.cwiseMin(p), high = high.cwiseMax(p);
      }
      for (int y = bucket(low.y(), sheet.height); y <= bucket(high.y(), sheet.height); ++y)
        for (int x = bucket(low.x(), sheet.width); x <= bucket(high.x(), sheet.width); ++x)
          buckets_[static_cast<std::size_t>(y) * kAcross + x].push_back(i);
    }
  }

  // -1 off the sheet.
  double grey(double x, double y) const {
    if (x < 0 || y < 0 || x >= sheet_.width || y >= sheet_.height) return -1;
    const auto& inks =
        buckets_[static_cast<std::size_t>(bucket(y, sheet_.height)) * kAcross + bucket(x, sheet_.width)];
    for (auto i = inks.rbegin(); i != inks.rend(); ++i)
      if (covers(sheet_.inks[*i], {x, y})) return sheet_.inks[*i].black ? options_.ink : options_.paper;
    return options_.paper;
  }

 private:
  static constexpr int kAcross = 96;
  static int bucket(double at, double size) {
    return std::clamp(static_cast<int>(at / size * kAcross), 0, kAcross - 1);
  }

  static bool covers(const calib::Ink& ink, const Vector2d& p) {
    if (ink.radius > 0) return (p - ink.center).squaredNorm() < ink.radius * ink.radius;
    bool in = false;
    for (const auto& loop : ink.loops)
      for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++)
        if ((loop[i].y() > p.y()) != (loop[j].y() > p.y()) &&
            p.x() < loop[i].x() +
                        (p.y() - loop[i].y()) * (loop[j].x() - loop[i].x()) / (loop[j].y() - loop[i].y()))
          in = !in;
    return in;
  }

  const calib::Sheet& sheet_;
  const BoardPictureOptions options_;
  std::vector<std::vector<std::size_t>> buckets_;
};

// What a ray from the camera meets.
class Scene {
 public:
  Scene(const calib::TargetDesign& target, const Rigid3& cam_from_target, const BoardPictureOptions& o)
      : options_(o) {
    const calib::Wand* wand = std::get_if<calib::Wand>(&target);
    if (wand && wand->ball > 0) {
      radius_ = wand->ball / 2;
      for (const double x : wand->positions) balls_.push_back(cam_from_target * Vector3d(x, 0, 0));
      return;
    }
    sheets_ = calib::target_sheets(target);
    papers_.reserve(sheets_.size());
    for (const calib::Sheet& sheet : sheets_) {
      papers_.emplace_back(sheet, o);
      sheet_from_cam_.push_back((cam_from_target * sheet.target_from_sheet).inverse());
    }
  }

  double grey(const Vector3d& ray) const {
    if (!balls_.empty()) return ball_grey(ray);
    double nearest = 1e9, found = options_.background;
    for (std::size_t i = 0; i < papers_.size(); ++i) {
      const Vector3d origin = sheet_from_cam_[i].translation, direction = sheet_from_cam_[i].rotation * ray;
      if (direction.z() <= 0) continue;  // from behind: z goes into the paper
      const double depth = -origin.z() / direction.z();
      if (depth <= 0 || depth >= nearest) continue;
      const double g =
          papers_[i].grey(origin.x() + depth * direction.x(), origin.y() + depth * direction.y());
      if (g < 0) continue;
      nearest = depth;
      found = g;
    }
    return found;
  }

 private:
  double ball_grey(const Vector3d& ray) const {
    for (const Vector3d& c : balls_) {
      const double along = ray.dot(c), square = ray.squaredNorm();
      if (along > 0 && c.squaredNorm() - along * along / square < radius_ * radius_)
        return options_.ball_glow;
    }
    return options_.ball_dark;
  }

  BoardPictureOptions options_;
  std::vector<calib::Sheet> sheets_;
  std::vector<Paper> papers_;
  std::vector<Rigid3> sheet_from_cam_;
  std::vector<Vector3d> balls_;
  double radius_ = 0;
};

void blur(std::vector<double>& grey, int width, int height, double sigma) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> kernel;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) sum += kernel.emplace_back(std::exp(-0.5 * i * i / (sigma * sigma)));
  for (const bool across : {true, false}) {
    const std::vector<double> from = grey;
    parallel_for(static_cast<std::size_t>(height), 0, [&](std::size_t row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < width; ++x) {
        double g = 0;
        for (int i = -reach; i <= reach; ++i) {
          const int u = across ? std::clamp(x + i, 0, width - 1) : x,
                    v = across ? y : std::clamp(y + i, 0, height - 1);
          g += kernel[static_cast<std::size_t>(i + reach)] * from[static_cast<std::size_t>(v) * width + u];
        }
        grey[static_cast<std::size_t>(y) * width + x] = g / sum;
      }
    });
  }
}

}  // namespace

Image board_picture(const calib::TargetDesign& target, const CameraModel& model,
                    const Rigid3& cam_from_target, const BoardPictureOptions& options) {
  const Scene scene(target, cam_from_target, options);
  const int w = model.width, h = model.height, across = w + 1;
  // The rays through the corners of all pixels; between them rays are interpolated.
  std::vector<Vector3d> rays(static_cast<std::size_t>(across) * (h + 1));
  std::vector<double> corner(rays.size());
  parallel_for(static_cast<std::size_t>(h) + 1, 0, [&](std::size_t y) {
    for (int x = 0; x < across; ++x) {
      const std::size_t i = y * across + x;
      rays[i] =
          unproject(model, {static_cast<double>(x), static_cast<double>(y)}).value_or(Vector3d(0, 0, -1));
      corner[i] = rays[i].z() > 0 ? scene.grey(rays[i]) : options.background;
    }
  });
  std::vector<double> grey(static_cast<std::size_t>(w) * h);
  const int n = options.samples;
  parallel_for(static_cast<std::size_t>(h), 0, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < w; ++x) {
      auto at = [&](int u, int v) {
        return static_cast<std::size_t>(std::clamp(v, 0, h)) * across + std::clamp(u, 0, w);
      };
      double& g = grey[row * w + x];
      g = corner[at(x, y)];
      bool edge = false;
      for (int v = y - 1; v <= y + 2; ++v)
        for (int u = x - 1; u <= x + 2; ++u) edge |= corner[at(u, v)] != g;
      if (!edge) continue;
      g = 0;
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          // A turned lattice: no two samples share a column or a row, so that straight edges fall between n²
          // of them.
          const double a = (i + (j + 0.5) / n) / n, b = (j + (n - i - 0.5) / n) / n;
          const Vector3d ray = (1 - b) * ((1 - a) * rays[at(x, y)] + a * rays[at(x + 1, y)]) +
                               b * ((1 - a) * rays[at(x, y + 1)] + a * rays[at(x + 1, y + 1)]);
          g += ray.z() > 0 ? scene.grey(ray) : options.background;
        }
      }
      g /= n * n;
    }
  });
  if (options.blur > 0) blur(grey, w, h, options.blur);
  Image image(w, h, 1);
  parallel_for(static_cast<std::size_t>(h), 0, [&](std::size_t row) {
    Random random(mix(options.seed * 1'000'003 + row));
    for (int x = 0; x < w; ++x) {
      double g = grey[row * w + x];
      if (options.noise > 0) g += options.noise * random.normal();
      *image.at(x, static_cast<int>(row)) = static_cast<std::uint8_t>(std::clamp(std::lround(g), 0L, 255L));
    }
  });
  return image;
}

std::vector<std::optional<Vector2d>> true_pixels(const calib::TargetDesign& target, const CameraModel& model,
                                                 const Rigid3& cam_from_target) {
  std::vector<std::optional<Vector2d>> pixels;
  for (const Vector3d& p : calib::target_points(target))
    pixels.push_back(project(model, cam_from_target * p));
  return pixels;
}

CameraModel simple_camera(int width, int height, double field_of_view, Lens lens) {
  const double f = width / 2.0 / std::tan(field_of_view * std::numbers::pi / 360);
  return {.width = width,
          .height = height,
          .fx = f,
          .fy = f,
          .cx = width / 2.0,
          .cy = height / 2.0,
          .lens = lens};
}

Rigid3 before_camera(const calib::TargetDesign& target, double distance, const Vector3d& degrees,
                     const Vector3d& shift) {
  Vector3d low = Vector3d::Constant(1e9), high = -low;
  for (const Vector3d& p : calib::target_points(target)) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3d r = degrees * std::numbers::pi / 180;
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(r.z(), Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(r.y(), Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(r.x(), Vector3d::UnitX());
  // The target's y points up and its z at the viewer; the camera's y points down and its z away.
  const Eigen::Quaterniond rotation =
      turn * Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  return {rotation, Vector3d(0, 0, distance) + shift - rotation * (0.5 * (low + high))};
}

}  // namespace floatstage::test
