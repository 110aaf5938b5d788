#include "core/synthetic/photograph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace floatstage::synthetic {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3f;

// Pixels that the performer can touch: the bounding boxes of all projected triangles, and one pixel more for
// what the lens bends. Without it most rays would be spent on cloth, and strands thinner than a pixel could
// be missed.
std::vector<std::uint8_t> touched_pixels(const TracingCamera& camera, const StageScene& scene) {
  const int w = camera.model().width, h = camera.model().height;
  std::vector<std::uint8_t> touched(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0);
  std::vector<Vector2f> pixels;
  pixels.reserve(scene.positions().size());
  for (const Vector3f& p : scene.positions()) {
    const std::optional<Vector2d> pixel = project(camera.model(), camera.cam_from_world() * p.cast<double>());
    if (!pixel)
      return std::vector<std::uint8_t>(touched.size(), 1);  // beside or behind the camera: look everywhere
    pixels.push_back(pixel->cast<float>());
  }
  const std::vector<std::uint32_t>& triangles = scene.performer().triangles();
  auto clamped = [](float v, int limit) {
    return static_cast<int>(std::clamp(std::floor(v), -1.0f, static_cast<float>(limit)));
  };
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Vector2f &a = pixels[triangles[t]], &b = pixels[triangles[t + 1]], &c = pixels[triangles[t + 2]];
    const Vector2f low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const int x0 = std::max(clamped(low.x() - 1, w), 0), x1 = std::min(clamped(high.x() + 1, w), w - 1);
    const int y0 = std::max(clamped(low.y() - 1, h), 0), y1 = std::min(clamped(high.y() + 1, h), h - 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        touched[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] = 1;
  }
  return touched;
}

// Rays are gathered over the pixels of a row and traced eight at a time.
class RowTracer {
 public:
  RowTracer(const TracingCamera& camera, const StageScene& scene, const PhotographOptions& options)
      : camera_(camera),
        scene_(scene),
        options_(options),
        metres_per_depth_(static_cast<float>(1 / (camera.model().fx * options.samples_across))) {}

  struct Pixel {
    Vector3f sum = Vector3f::Zero();
    int hits = 0, of_second = 0;
    float depth = std::numeric_limits<float>::infinity();
  };

  void begin_row() { pixels_.clear(); }

  void add_pixel(int x, int y) {
    const std::size_t pixel = pixels_.size();
    pixels_.emplace_back();
    const int n = options_.samples_across;
    add_ray(pixel, true, camera_.direction(x, y, 0.5f, 0.5f));
    const float step = 1 / static_cast<float>(n);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        // One sample a cell, and n² different offsets along either axis: an upright edge still has n² + 1
        // levels.
        const float sx = (static_cast<float>(i) + (static_cast<float>(j) + 0.5f) * step) * step;
        const float sy = (static_cast<float>(j) + (static_cast<float>(i) + 0.5f) * step) * step;
        add_ray(pixel, false, camera_.direction(x, y, sx, sy));
      }
    }
  }

  const std::vector<Pixel>& end_row() {
    trace();
    return pixels_;
  }

  bool stopped() const { return stopped_; }

 private:
  void add_ray(std::size_t pixel, bool center, const Vector3f& direction) {
    if (!(direction.squaredNorm() > 0)) return;  // the lens has no such ray
    const std::size_t k = static_cast<std::size_t>(count_);
    pixel_[k] = pixel;
    center_[k] = center;
    directions_[k] = direction;
    if (++count_ == kPacket) trace();
  }

  void trace() {
    if (count_ == 0) return;
    if (++packets_ % kPacketsBetweenLooks == 0 && options_.stop && options_.stop()) stopped_ = true;
    if (stopped_) {
      count_ = 0;
      return;
    }
    scene_.intersect(camera_.center(), directions_, count_, hits_);
    for (std::size_t k = 0; k < static_cast<std::size_t>(count_); ++k) {
      const Hit& hit = hits_[k];
      if (hit.triangle == kMiss) continue;
      Pixel& pixel = pixels_[pixel_[k]];
      if (center_[k]) {
        pixel.depth = hit.t;
        continue;
      }
      pixel.sum += scene_.shade(hit, hit.t * metres_per_depth_, options_.spill, options_.seed, options_.dress)
                       .cwiseMin(1.0f);
      ++pixel.hits;
      pixel.of_second += scene_.performer().part_of_triangle(hit.triangle).body;
    }
    count_ = 0;
  }

  const TracingCamera& camera_;
  const StageScene& scene_;
  const PhotographOptions options_;
  const float metres_per_depth_;
  static constexpr std::uint64_t kPacketsBetweenLooks = 512;  // some milliseconds
  std::vector<Pixel> pixels_;
  std::uint64_t packets_ = 0;
  bool stopped_ = false;
  int count_ = 0;
  std::array<std::size_t, kPacket> pixel_{};
  std::array<bool, kPacket> center_{};
  std::array<Vector3f, kPacket> directions_;
  std::array<Hit, kPacket> hits_;
};

Vector3f plate_color(const Image& plate, int x, int y) {
  const std::uint8_t* p = plate.at(x, y);
  return Vector3f(p[0], p[1], p[2]) / 255.0f;
}

}  // namespace

TracingCamera::TracingCamera(const CameraModel& model, const Rigid3& cam_from_world)
    : model_(model),
      cam_from_world_(cam_from_world),
      center_(cam_from_world.center().cast<float>()),
      world_from_cam_(cam_from_world.rotation.conjugate().toRotationMatrix().cast<float>()) {
  corners_.reserve(static_cast<std::size_t>(model.width + 1) * static_cast<std::size_t>(model.height + 1));
  for (int y = 0; y <= model.height; ++y) {
    for (int x = 0; x <= model.width; ++x) {
      const std::optional<Eigen::Vector3d> ray = unproject(model, {x, y});
      corners_.push_back(ray ? Vector2f(ray->head<2>().cast<float>())
                             : Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
    }
  }
}

Vector3f TracingCamera::direction(int x, int y, float sx, float sy) const {
  const std::size_t stride = static_cast<std::size_t>(model_.width) + 1;
  const Vector2f* c = corners_.data() + static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
  const Vector2f top = c[0] + sx * (c[1] - c[0]), bottom = c[stride] + sx * (c[stride + 1] - c[stride]);
  const Vector2f xy = top + sy * (bottom - top);
  return world_from_cam_ * Vector3f(xy.x(), xy.y(), 1);
}

Image photograph_room(const TracingCamera& camera, const Room& room, const std::function<bool()>& stop) {
  Image plate(camera.model().width, camera.model().height, 3);
  for (int y = 0; y < plate.height && !(stop && stop()); ++y) {
    for (int x = 0; x < plate.width; ++x) {
      const Vector3f d = camera.direction(x, y, 0.5f, 0.5f);
      if (!(d.squaredNorm() > 0)) continue;
      const Vector3f color = room.color(camera.center(), d);
      for (int c = 0; c < 3; ++c)
        plate.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(color[c], 0.0f, 1.0f)));
    }
  }
  return plate;
}

Exposure photograph(const TracingCamera& camera, const StageScene& scene, const Image& plate,
                    const PhotographOptions& options) {
  const int w = camera.model().width, h = camera.model().height;
  const std::size_t count = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  Exposure out{w, h, std::vector<Vector3f>(count), std::vector<std::uint8_t>(count, 0),
               std::vector<float>(count, std::numeric_limits<float>::infinity())};
  if (scene.performer().bodies() > 1) out.alpha_of.assign(2, std::vector<std::uint8_t>(count, 0));
  const std::vector<std::uint8_t> touched = touched_pixels(camera, scene);
  const float rays = static_cast<float>(options.samples_across * options.samples_across);
  RowTracer tracer(camera, scene, options);
  for (int y = 0; y < h && !tracer.stopped(); ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
    tracer.begin_row();
    for (int x = 0; x < w; ++x)
      if (touched[row + static_cast<std::size_t>(x)]) tracer.add_pixel(x, y);
    auto pixel = tracer.end_row().begin();
    for (int x = 0; x < w; ++x) {
      const std::size_t i = row + static_cast<std::size_t>(x);
      const Vector3f background = plate_color(plate, x, y);
      out.color[i] = background;
      if (!touched[i]) continue;
      const float coverage = static_cast<float>(pixel->hits) / rays;
      out.color[i] = pixel->sum / rays + (1 - coverage) * background;
      out.alpha[i] = static_cast<std::uint8_t>(std::lround(255 * coverage));
      for (std::size_t body = 0; body < out.alpha_of.size(); ++body)
        out.alpha_of[body][i] = static_cast<std::uint8_t>(std::lround(
            255 * static_cast<float>(body == 0 ? pixel->hits - pixel->of_second : pixel->of_second) / rays));
      out.depth[i] = pixel->depth;
      ++pixel;
    }
  }
  return out;
}

}  // namespace floatstage::synthetic
