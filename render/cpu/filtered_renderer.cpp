// Filtered Blending: M. Eisemann, Error-Concealed Image-Based Rendering, ch. 10. Whatever depth the proxy
// misses, the right colour of a photograph lies on the line of disparity; the photograph is filtered along
// it, then blended as "linear" does. Where it differs: colours count by their opacity, and narrow filters
// read photographs by a spline. The pass of render/gl/shaders/filtered.comp.
// docs/adr/0210-filtered-blending.md.
#include <algorithm>
#include <cmath>
#include <span>

#include "render/cpu/inspection.h"
#include "render/cpu/renderers.h"
#include "render/cpu/row_mean.h"
#include "render/photo_pyramid.h"
#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

constexpr float kLeastShare = 0.25F;  // of a filter that must lie on the subject
constexpr float kNearest = 0.1F;      // of the depth: a line of disparity never reaches the eye

class FilteredRenderer : public ViewRenderer {
 public:
  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output("filtered", options.output); !ok) return forward(ok);
    const Projection::Wanted wanted{.margin = 0, .levels = true, .mattes = has_soft_outline(options)};
    if (Result<void> ok = projection_.run(scene, view, options, wanted); !ok) return forward(ok);
    picture_.begin(view, options.background);
    error_ =
        static_cast<float>(options.uncertainty * static_cast<double>(scene.impl().box.diagonal().norm()));
    if (!projection_.window().empty()) {
      if (is_shared_intermediate(options.output)) {
        draw_intermediate(projection_, scene, view, options, picture_);
      } else {
        projection_.for_rows([&](int y, RowMemory& memory) {
          blend_row(y, options.output == RenderOutput::Ghosting, memory);
        });
      }
      if (Result<void> ok = picture_.soften(projection_, options); !ok) return forward(ok);
    }
    RenderedView drawn = rendered_view(scene, view, projection_, picture_);
    if (options.output == RenderOutput::Color && options.motion_blur > 0)
      drawn.picture = &blurred(static_cast<float>(options.motion_blur));
    else
      history_.clear();
    return drawn;
  }

  void reset_history() override { history_.clear(); }

 private:
  // One photograph's line of disparity at each pixel of a row.
  struct Lines {
    float *u, *v, *du, *dv;  ///< middle, and from end to end
  };

  // The ends of the line: the proxy moved along the viewing ray.
  void find_lines(std::size_t slot, const PixelList& points, const float* ray_length, Lines& lines,
                  RowMemory& memory) const {
    const auto count = static_cast<std::size_t>(points.count);
    float *near_z = memory.floats(count), *far_z = memory.floats(count);
    float *u1 = memory.floats(count), *v1 = memory.floats(count), *u2 = memory.floats(count),
          *v2 = memory.floats(count);
    std::int32_t* inside = memory.ints(count);
    for (std::size_t i = 0; i < count; ++i) {
      const float z = 1 / points.inverse_z[i], along = error_ / ray_length[i];
      near_z[i] = 1 / std::max(z - along, kNearest * z);
      far_z[i] = 1 / (z + along);
    }
    const PhotoCamera& camera = projection_.camera(slot);
    project_points(camera, projection_.rays(), {points.x, nullptr, near_z, points.row_y, points.count}, u1,
                   v1, inside);
    project_points(camera, projection_.rays(), {points.x, nullptr, far_z, points.row_y, points.count}, u2, v2,
                   inside);
    project_points(camera, projection_.rays(), points, lines.u, lines.v, inside);
    for (std::size_t i = 0; i < count; ++i) {
      lines.du[i] = lines.dv[i] = 0;
      if ((u1[i] == -1 && v1[i] == -1) || (u2[i] == -1 && v2[i] == -1)) continue;  // beyond the lens
      lines.u[i] = 0.5F * (u1[i] + u2[i]);
      lines.v[i] = 0.5F * (v1[i] + v2[i]);
      lines.du[i] = u2[i] - u1[i];
      lines.dv[i] = v2[i] - v1[i];
    }
  }

  // Filters a photograph at the pixels that want it.
  void filter_row(std::size_t slot, const Covered::Row& row, const Lines& lines, const std::int32_t* wanted,
                  float* colors, RowMemory& memory) const {
    const auto n = static_cast<std::size_t>(row.count);
    const PhotoLevels& photo = projection_.photo(slot);
    const float* footprint = projection_.footprint(slot);
    float *u = memory.floats(n), *v = memory.floats(n), *read = memory.floats(4 * n),
          *sum = memory.floats(4 * n);
    float *total = memory.floats(n), *area = memory.floats(n);
    float *step_u = memory.floats(n), *step_v = memory.floats(n);
    std::int32_t *now = memory.ints(n), *taps = memory.ints(n), *sharp = memory.ints(n);
    std::fill_n(sum, 4 * n, 0.F);
    std::fill_n(total, n, 0.F);
    std::array<int, 2> most{};  // taps, of soft lines and of sharp ones
    for (std::size_t i = 0; i < n; ++i) {
      if (wanted[i] == 0) continue;
      const FilterLine line(lines.du[i], lines.dv[i]);
      taps[i] = line.taps;
      step_u[i] = line.step_u;
      step_v[i] = line.step_v;
      sharp[i] = line.sharp ? 1 : 0;
      // A level alone is what a footprint of its pixels' size reads.
      area[i] = line.level > 0 ? area_of_level(line.level) : 0;
      if (footprint != nullptr) area[i] = std::max(area[i], footprint[row.list + i]);
      int& longest = most[static_cast<std::size_t>(sharp[i])];
      longest = std::max(longest, line.taps);
    }
    for (std::int32_t kind = 0; kind < 2; ++kind)
      for (int tap = 0; tap < most[static_cast<std::size_t>(kind)]; ++tap) {
        for (std::size_t i = 0; i < n; ++i) {
          now[i] = wanted[i] != 0 && sharp[i] == kind && tap < taps[i];
          if (now[i] == 0) continue;
          const float place = FilterLine::place(tap, taps[i]);
          u[i] = lines.u[i] + place * step_u[i];
          v[i] = lines.v[i] + place * step_v[i];
        }
        photo.read(kind == 1 && projection_.sharp(), u, v, area, now, row.count, read, memory);
        for (std::size_t i = 0; i < n; ++i) {
          if (now[i] == 0) continue;
          const float w = FilterLine::weight(tap, taps[i]), a = w * read[4 * i + 3] / 255;
          for (std::size_t c = 0; c < 3; ++c) sum[4 * i + c] += a * read[4 * i + c];
          sum[4 * i + 3] += a;
          total[i] += w;
        }
      }
    // Where most of the line lies beside the subject, its middle speaks alone.
    bool any = false;
    for (std::size_t i = 0; i < n; ++i)
      any |= now[i] = wanted[i] != 0 && sum[4 * i + 3] < kLeastShare * total[i];
    if (any) projection_.read(slot, row, lines.u, lines.v, now, colors, memory);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t c = 0; wanted[i] != 0 && now[i] == 0 && c < 3; ++c)
        colors[4 * i + c] = std::clamp(sum[4 * i + c] / sum[4 * i + 3], 0.F, 255.F);
  }

  void blend_row(int y, bool ghosting, RowMemory& memory) {
    const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
    const auto count = static_cast<std::size_t>(row.count);
    const std::size_t listed = projection_.choice().listed.size();
    const PixelList points{projection_.covered().x.data() + row.list, nullptr,
                           projection_.covered().inverse_z.data() + row.list, static_cast<float>(y) + 0.5F,
                           row.count};
    const ViewRays& rays = projection_.rays();
    RowMean mean(count, kFaint, memory);
    float* length = memory.floats(count);
    const float ry = (points.row_y - rays.cy) * rays.inverse_fy;
    for (std::size_t i = 0; i < count; ++i) {
      const float rx = (points.x[i] - rays.cx - rays.skew * ry) * rays.inverse_fx;
      length[i] = std::sqrt(rx * rx + ry * ry + 1);
    }
    std::int32_t* wanted = memory.ints(count);
    std::array<RowShare, kMostListed> shares{};
    std::array<float*, kMostListed> colors{};
    for (std::size_t slot = 0; slot < listed; ++slot) colors[slot] = memory.floats(4 * count);
    const std::size_t mark = memory.used();
    for (std::size_t slot = 0; slot < listed; ++slot) {
      const float* weight = projection_.weight(slot) + row.list;
      if (!mark_weighty(weight, kFaint, count, wanted)) continue;
      memory.take_back(mark);
      Lines lines{memory.floats(count), memory.floats(count), memory.floats(count), memory.floats(count)};
      find_lines(slot, points, length, lines, memory);
      filter_row(slot, row, lines, wanted, colors[slot], memory);
      mean.add(shares[slot] = {weight, colors[slot]});
    }
    picture_.write(projection_, y, mean.finish(ghosting, std::span(shares).first(listed)), 4);
  }

  // The pictures before fade: each leaves its share, so what rests tends to what it is.
  const Image& blurred(float share) {
    const Image& now = picture_.image();
    const bool fits = history_.size() == now.pixels.size() && blurred_.width == now.width;
    if (!fits) history_.assign(now.pixels.begin(), now.pixels.end());
    blurred_ = now;
    for (std::size_t i = 0; i < history_.size(); ++i) {
      history_[i] = share * history_[i] + (1 - share) * static_cast<float>(now.pixels[i]);
      blurred_.pixels[i] = static_cast<std::uint8_t>(history_[i] + 0.5F);
    }
    return blurred_;
  }

  float error_ = 0;  // m, along the viewing ray
  Projection projection_;
  Picture picture_;
  std::vector<float> history_;
  Image blurred_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_filtered_renderer() {
  return std::unique_ptr<ViewRenderer>(std::make_unique<FilteredRenderer>());
}

}  // namespace floatstage::render::cpu
