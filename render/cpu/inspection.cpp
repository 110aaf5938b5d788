#include "render/cpu/inspection.h"

#include <algorithm>
#include <cmath>

#include "render/cpu/false_color.h"
#include "render/cpu/footprint_kernels.h"
#include "render/cpu/position_kernels.h"
#include "render/cpu/row_mean.h"
#include "render/scene_impl.h"

namespace floatstage::render::cpu {
namespace {

constexpr float kSmallestArea = 1e-12F;  // px²

PixelList row_points(const Projection& projection, int y) {
  const Covered::Row& row = projection.covered().rows[static_cast<std::size_t>(y)];
  return {projection.covered().x.data() + row.list, nullptr, projection.covered().inverse_z.data() + row.list,
          static_cast<float>(y) + 0.5F, row.count};
}

// Draws one output, row by row.
class Intermediate {
 public:
  Intermediate(const Projection& projection, const Scene& scene, const View& view,
               const RendererOptions& options)
      : projection_(projection),
        choice_(projection.choice()),
        output_(options.output),
        shown_(shown_slots(scene, projection.choice(), options).camera),
        fx_(static_cast<float>(view.model.fx)),
        fy_(static_cast<float>(view.model.fy)) {
    const Eigen::AlignedBox3f& box = scene.impl().box;
    middle_ = static_cast<float>((view.view_from_world * Eigen::Vector3d(box.center().cast<double>())).z());
    radius_ = 0.5F * box.diagonal().norm() + 1e-6F;
    depth_error_ =
        static_cast<float>(options.uncertainty * static_cast<double>(scene.impl().box.diagonal().norm()));
  }

  void row(int y, float* rgb, RowMemory& memory) const {
    switch (output_) {
      case RenderOutput::Opacity:  // Picture::soften() draws it
        return;
      case RenderOutput::Depth:
        return depth(y, rgb);
      case RenderOutput::Projected:
        return photograph(y, rgb, memory);
      case RenderOutput::Aliasing:
        return aliasing(y, rgb, memory);
      case RenderOutput::Predicted:
        return predicted(y, rgb, memory);
      default:
        return amounts(y, rgb);
    }
  }

 private:
  const Covered::Row& covered_row(int y) const {
    return projection_.covered().rows[static_cast<std::size_t>(y)];
  }
  std::size_t count(int y) const { return static_cast<std::size_t>(covered_row(y).count); }

  Normals row_normals(int y, RowMemory& memory) const {
    float *x = memory.floats(count(y)), *y_ = memory.floats(count(y)), *z = memory.floats(count(y));
    projection_.write_normals(y, x, y_, z);
    return {x, y_, z};
  }

  void depth(int y, float* rgb) const {
    for (std::size_t i = 0; i < count(y); ++i) {
      const float z = 1 / projection_.covered().inverse_z[covered_row(y).list + i];
      const float bright = 1 - std::clamp((z - middle_ + radius_) / (2 * radius_), 0.F, 1.F);
      std::fill_n(rgb + 3 * i, 3, 255 * bright);
    }
  }

  // Weights or visibilities, in the cameras' colours.
  void amounts(int y, float* rgb) const {
    const std::size_t shown = output_ == RenderOutput::Weights ? choice_.listed.size() : choice_.chosen;
    const float part = 1 / static_cast<float>(shown);
    for (std::size_t slot = 0; slot < shown; ++slot) {
      const std::array<float, 3> color = camera_color(choice_.listed[slot]);
      for (std::size_t i = 0; i < count(y); ++i) {
        const std::size_t at = covered_row(y).list + i;
        const float amount = output_ == RenderOutput::Weights ? projection_.weight(slot)[at]
                             : output_ == RenderOutput::Visibility
                                 ? part * static_cast<float>(projection_.visible()[at] >> slot & 1)
                                 : part * projection_.soft(slot)[at];
        for (std::size_t c = 0; c < 3; ++c) rgb[3 * i + c] += amount * color[c];
      }
    }
  }

  void photograph(int y, float* rgb, RowMemory& memory) const {
    if (shown_ < 0) return;
    const auto slot = static_cast<std::size_t>(shown_);
    const Covered::Row& row = covered_row(y);
    float *u = memory.floats(count(y)), *v = memory.floats(count(y)), *rgba = memory.floats(4 * count(y));
    std::int32_t* seen = memory.ints(count(y));
    project_points(projection_.camera(slot), projection_.rays(), row_points(projection_, y), u, v, seen);
    for (std::size_t i = 0; i < count(y); ++i) seen[i] = projection_.visible()[row.list + i] >> slot & 1;
    projection_.read(slot, row, u, v, seen, rgba, memory);
    for (std::size_t i = 0; i < count(y); ++i)
      if (seen[i] != 0) std::copy_n(rgba + 4 * i, 3, rgb + 3 * i);
  }

  void aliasing(int y, float* rgb, RowMemory& memory) const {
    float *sum = memory.floats(count(y)), *total = memory.floats(count(y)),
          *spacing = memory.floats(count(y));
    std::fill_n(sum, count(y), 0.F);
    std::fill_n(total, count(y), 0.F);
    const Normals normals = row_normals(y, memory);
    for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
      pixel_spacings(projection_, slot, y, normals, spacing);
      const float* weight = projection_.weight(slot) + covered_row(y).list;
      for (std::size_t i = 0; i < count(y); ++i) {
        sum[i] += weight[i] * spacing[i];
        total[i] += weight[i];
      }
    }
    for (std::size_t i = 0; i < count(y); ++i) {
      const std::array<float, 3> color = spacing_color(total[i] > 0 ? sum[i] / total[i] : 1);
      std::copy(color.begin(), color.end(), rgb + 3 * i);
    }
  }

  // Where a camera shows the surface of a proxy that is off by depth_error_ along the viewing ray: px of the
  // view, to first order (docs/algorithms/floating-textures.md: u_j).
  void shifts(std::size_t slot, int y, const Normals& n, float* x, float* dy) const {
    const ViewRays& rays = projection_.rays();
    const std::array<float, 3> center = center_in_view(rays, projection_.camera(slot).center);
    const PixelList points = row_points(projection_, y);
    const std::array<float, 9>& m = rays.world_from_view;
    const float ry = (points.row_y - rays.cy) * rays.inverse_fy;
    for (std::size_t i = 0; i < count(y); ++i) {
      const float rx = (points.x[i] - rays.cx - rays.skew * ry) * rays.inverse_fx,
                  z = 1 / points.inverse_z[i];
      const float nx = m[0] * n.x[i] + m[3] * n.y[i] + m[6] * n.z[i],
                  ny = m[1] * n.x[i] + m[4] * n.y[i] + m[7] * n.z[i],
                  nz = m[2] * n.x[i] + m[5] * n.y[i] + m[8] * n.z[i];
      const std::array<float, 2> u = parallax({rx, ry}, z, {nx, ny, nz}, center);
      const float deeper = depth_error_ / std::sqrt(rx * rx + ry * ry + 1);
      const float scale = deeper * std::abs(nx * rx + ny * ry + nz) / z;
      x[i] = fx_ * scale * u[0];
      dy[i] = fy_ * scale * u[1];
    }
  }

  void predicted(int y, float* rgb, RowMemory& memory) const {
    const std::size_t pixels = count(y), chosen = choice_.listed.size();
    const Normals normals = row_normals(y, memory);
    std::array<float*, kMostListed> x{}, dy{}, spacing{};
    for (std::size_t slot = 0; slot < chosen; ++slot) {
      for (auto* lists : {&x, &dy, &spacing}) (*lists)[slot] = memory.floats(pixels);
      shifts(slot, y, normals, x[slot], dy[slot]);
      pixel_spacings(projection_, slot, y, normals, spacing[slot]);
    }
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t at = covered_row(y).list + i;
      BlendClass worst = BlendClass::Sharp;
      for (std::size_t a = 0; a < chosen; ++a)
        for (std::size_t b = a; b < chosen; ++b) {
          if (projection_.weight(a)[at] < kFaint || projection_.weight(b)[at] < kFaint) continue;
          const float apart = std::hypot(x[a][i] - x[b][i], dy[a][i] - dy[b][i]);
          worst = std::max(worst, blend_class(apart, spacing[a][i], spacing[b][i]));
        }
      const std::array<float, 3> color = class_color(worst);
      std::copy(color.begin(), color.end(), rgb + 3 * i);
    }
  }

  const Projection& projection_;
  const CameraChoice& choice_;
  const RenderOutput output_;
  const int shown_;
  const float fx_, fy_;
  float middle_ = 0, radius_ = 0, depth_error_ = 0;
};

}  // namespace

void pixel_spacings(const Projection& projection, std::size_t slot, int y, const Normals& normals,
                    float* spacing) {
  const PixelList points = row_points(projection, y);
  footprints(projection.camera(slot), projection.rays(), points, normals, spacing);
  for (int i = 0; i < points.count; ++i) spacing[i] = 1 / std::sqrt(std::max(spacing[i], kSmallestArea));
}

void draw_intermediate(Projection& projection, const Scene& scene, const View& view,
                       const RendererOptions& options, Picture& picture) {
  const Intermediate intermediate(projection, scene, view, options);
  projection.for_rows([&](int y, RowMemory& memory) {
    const auto count = static_cast<std::size_t>(projection.covered().rows[static_cast<std::size_t>(y)].count);
    float* rgb = memory.floats(3 * count);
    std::fill_n(rgb, 3 * count, 0.F);
    intermediate.row(y, rgb, memory);
    picture.write(projection, y, rgb, 3);
  });
}

}  // namespace floatstage::render::cpu
