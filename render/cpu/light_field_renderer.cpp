// Light field rendering (Levoy and Hanrahan 1996) on the proxy: the four cameras around where the viewing ray
// meets the cameras' plane, weighted bilinearly. The pass of render/gl/shaders/light_field.comp.
#include <algorithm>
#include <array>
#include <limits>

#include "render/cpu/footprint_kernels.h"
#include "render/cpu/inspection.h"
#include "render/cpu/photo_levels.h"
#include "render/cpu/renderers.h"
#include "render/cpu/row_mean.h"
#include "render/light_field.h"
#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

class LightFieldRenderer : public ViewRenderer {
 public:
  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output("light-field", options.output); !ok) return forward(ok);
    Result<CameraGrid> grid = camera_grid(scene.impl().cameras);
    if (!grid) return forward(grid);
    plane_ = LightFieldPlane(*grid, view.view_from_world.center());
    const Projection::Wanted wanted{.margin = 0,
                                    .mattes = has_soft_outline(options),
                                    .unreached = 1};  // its cameras are others than those listed
    if (Result<void> ok = projection_.run(scene, view, options, wanted); !ok) return forward(ok);
    picture_.begin(view, options.background);
    take_photographs(scene.impl(), view);
    if (!projection_.window().empty()) {
      if (options.output == RenderOutput::Depth || options.output == RenderOutput::Opacity)
        draw_intermediate(projection_, scene, view, options, picture_);
      else
        projection_.for_rows([&](int y, RowMemory& memory) {
          blend_row(y, options.output == RenderOutput::Ghosting, memory);
        });
      if (Result<void> ok = picture_.soften(projection_, options, false); !ok) return forward(ok);
    }
    RenderedView drawn = rendered_view(scene, view, projection_, picture_);
    drawn.cameras = strongest(scene.impl(), plane_, view);
    return drawn;
  }

 private:
  // A row's pixels: the cell that each ray goes through, and where in it.
  struct Cells {
    std::int32_t* first;  ///< place in the grid of the cell's camera at the top left
    float *right, *down;  ///< 0 … 1
  };

  void take_photographs(const Scene::Impl& s, const View& view) {
    photos_.resize(plane_.cameras.size());
    minified_ = false;
    for (int camera : plane_.cameras)
      minified_ |= deepest_level(s.cameras[static_cast<std::size_t>(camera)], view, s.box) > 0;
    const PhotoPyramid* pyramid = minified_ ? &PhotoPyramid::of(s, plane_.cameras) : nullptr;
    for (std::size_t place = 0; place < photos_.size(); ++place) {
      const auto i = static_cast<std::size_t>(plane_.cameras[place]);
      photos_[place].set(photo_camera(s.blocks[i], s.tiles[i]), pyramid, i);
    }
  }

  Cells find_cells(int y, RowMemory& memory) const {
    const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
    const auto count = static_cast<std::size_t>(row.count);
    Cells cells{memory.ints(count), memory.floats(count), memory.floats(count)};
    const ViewRays& rays = projection_.rays();
    const auto& m = rays.world_from_view;
    const float ry = (static_cast<float>(y) + 0.5F - rays.cy) * rays.inverse_fy;
    for (std::size_t i = 0; i < count; ++i) {
      const float rx = (projection_.covered().x[row.list + i] - rays.cx - rays.skew * ry) * rays.inverse_fx;
      const std::array<float, 3> way = {m[0] * rx + m[1] * ry + m[2], m[3] * rx + m[4] * ry + m[5],
                                        m[6] * rx + m[7] * ry + m[8]};
      const LightFieldPlane::Cell cell = plane_.cell(way);
      cells.first[i] = cell.first;
      cells.right[i] = cell.right;
      cells.down[i] = cell.down;
    }
    return cells;
  }

  void blend_row(int y, bool ghosting, RowMemory& memory) {
    const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
    const auto count = static_cast<std::size_t>(row.count);
    const Cells cells = find_cells(y, memory);
    RowMean mean(count, std::numeric_limits<float>::min(), memory);
    float *u = memory.floats(count), *v = memory.floats(count);
    std::int32_t *inside = memory.ints(count), *wanted = memory.ints(count);
    std::array<float*, 4> colors{}, weights{};
    for (std::size_t k = 0; k < 4; ++k) {
      colors[k] = memory.floats(4 * count);
      weights[k] = memory.floats(count);
      std::fill_n(weights[k], count, 0.F);
    }
    const PixelList points{projection_.covered().x.data() + row.list, nullptr,
                           projection_.covered().inverse_z.data() + row.list, static_cast<float>(y) + 0.5F,
                           row.count};
    float *nx = memory.floats(count), *ny = memory.floats(count), *nz = memory.floats(count);
    float* area = minified_ ? memory.floats(count) : nullptr;
    if (minified_) projection_.write_normals(y, nx, ny, nz);
    for (std::size_t camera = 0; camera < photos_.size(); ++camera) {
      for (std::size_t k = 0; k < 4; ++k) {
        const int place = static_cast<int>(camera) - plane_.offset(k);
        bool any = false;
        for (std::size_t i = 0; i < count; ++i) any |= wanted[i] = cells.first[i] == place ? 1 : 0;
        if (!any) continue;
        const PhotoLevels& photo = photos_[camera];
        project_points(photo.photograph(), projection_.rays(), points, u, v, inside);
        if (minified_) footprints(photo.photograph(), projection_.rays(), points, {nx, ny, nz}, area);
        photo.read(projection_.sharp(), u, v, area, wanted, row.count, colors[k], memory);
        for (std::size_t i = 0; i < count; ++i)
          if (wanted[i] != 0)
            weights[k][i] = LightFieldPlane::weight(k, cells.right[i], cells.down[i]) *
                            (inside[i] != 0 ? 1 : LightFieldPlane::kBeside);
      }
    }
    std::array<RowShare, 4> shares{};
    for (std::size_t k = 0; k < 4; ++k) mean.add(shares[k] = {weights[k], colors[k]});
    picture_.write(projection_, y, mean.finish(ghosting, shares), 4);
  }

  LightFieldPlane plane_;
  std::vector<PhotoLevels> photos_;  // row after row
  bool minified_ = false;
  Projection projection_;
  Picture picture_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_light_field_renderer() {
  return std::unique_ptr<ViewRenderer>(std::make_unique<LightFieldRenderer>());
}

}  // namespace floatstage::render::cpu
