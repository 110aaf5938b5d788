// Band-limiting: M. Eisemann, Error-Concealed Image-Based Rendering, §9.3.5, after Chai et al. 2000. What is
// blended is filtered beforehand until what the proxy puts apart runs together. The filter is that of ch. 10
// (Mitchell and Netravali 1988), whose samples lie one disparity apart. Where it differs: filters have a
// width a camera, and colours are weighted by their opacity. docs/adr/0208-band-limited-photographs.md.
#include "render/band_limit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/parallel.h"
#include "render/mitchell.h"

namespace floatstage::render {
namespace {

constexpr double kUnfiltered = 2 * kMitchellReach;  // px: as wide as the filter between the pixels themselves
constexpr float kLeastShare = 0.25F;                // of the filter that must lie on the subject

std::vector<float> taps(double width) {
  const auto spacing = static_cast<float>(width / kUnfiltered);
  const int reach = static_cast<int>(std::ceil(kMitchellReach * spacing)) - 1;
  std::vector<float> weights;
  for (int i = -reach; i <= reach; ++i) weights.push_back(mitchell(static_cast<float>(i) / spacing));
  return weights;
}

// One pass over lines of colours times opacity and opacity, along x or along y.
void filter(const std::vector<float>& from, int width, int height, bool along_x,
            const std::vector<float>& taps, std::vector<float>& to) {
  const int reach = static_cast<int>(taps.size()) / 2, length = along_x ? width : height;
  const std::ptrdiff_t step = along_x ? 4 : 4 * static_cast<std::ptrdiff_t>(width);
  parallel_for(static_cast<std::size_t>(height), 0, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const std::ptrdiff_t at = 4 * (static_cast<std::ptrdiff_t>(y) * width + x);
      const int here = along_x ? x : y;
      float sum[4] = {0, 0, 0, 0}, total = 0;
      for (int k = std::max(-reach, -here); k <= std::min(reach, length - 1 - here); ++k) {
        const float w = taps[static_cast<std::size_t>(k + reach)];
        const float* p = from.data() + at + k * step;
        for (int c = 0; c < 4; ++c) sum[c] += w * p[c];
        total += w;
      }
      for (int c = 0; c < 4; ++c) to[static_cast<std::size_t>(at + c)] = sum[c] / total;
    }
  });
}

std::vector<float> premultiplied(const SceneTile& tile) {
  std::vector<float> out(4 * static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height));
  float* to = out.data();
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x, to += 4) {
      const std::uint8_t* p = tile.at(x, y);
      const float alpha = static_cast<float>(p[3]) / 255;
      for (int c = 0; c < 3; ++c) to[c] = alpha * static_cast<float>(p[c]);
      to[3] = alpha;
    }
  return out;
}

// Colours that enough of the filter speaks for.
void put(const float* sum, std::uint8_t* pixel) {
  if (sum[3] < kLeastShare) return;
  for (int c = 0; c < 3; ++c)
    pixel[c] = static_cast<std::uint8_t>(std::lround(std::clamp(sum[c] / sum[3], 0.F, 255.F)));
}

class BandLimitedRenderer : public ViewRenderer {
 public:
  explicit BandLimitedRenderer(std::unique_ptr<ViewRenderer> linear) : linear_(std::move(linear)) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check(options); !ok) return forward(ok);
    if (scene.impl().cameras.empty()) return linear_->render(scene, view, options);  // says so
    const Result<const Scene*> filtered = filtered_scene(scene.impl(), options);
    if (!filtered) return forward(filtered);
    Result<RenderedView> picture = linear_->render(**filtered, view, options);
    if (!picture) return picture;
    const Scene::Impl& s = scene.impl();
    for (int& camera : picture->cameras) {
      const int slot = s.slot[static_cast<std::size_t>(camera)];
      camera = s.rig_index[static_cast<std::size_t>(slot)];
    }
    return picture;
  }

 private:
  // A scene's photographs, filtered: kept beside it until it or the filters change.
  struct Filtered {
    std::uint64_t version = 0;
    std::vector<double> widths;
    Scene scene;
  };

  static Result<const Scene*> filtered_scene(const Scene::Impl& s, const RendererOptions& options) {
    std::vector<double> widths;
    for (std::size_t i = 0; i < s.cameras.size(); ++i) widths.push_back(band_limit_of(s, i, options));
    if (!s.band_limited) s.band_limited = std::make_shared<Filtered>();
    auto* kept = static_cast<Filtered*>(s.band_limited.get());
    if (kept->version == s.version && kept->widths == widths) return &kept->scene;
    kept->version = 0;
    if (Result<void> ok = fill(s, widths, kept->scene); !ok) return forward(ok);
    kept->version = s.version;
    kept->widths = widths;
    return &kept->scene;
  }

  static Result<void> fill(const Scene::Impl& s, const std::vector<double>& widths, Scene& to) {
    Rig rig{s.ranked};
    for (RigCamera& camera : rig.cameras) camera.color = {};  // tiles have the rig's colours already
    std::vector<Image> pictures(s.cameras.size()), mattes(s.cameras.size());
    std::vector<PictureTile> tiles;
    for (std::size_t i = 0; i < s.cameras.size(); ++i) {
      SceneTile tile = s.tiles[i];
      band_limit(tile, widths[i]);
      pictures[i] = Image(tile.width, tile.height, 3);
      mattes[i] = Image(tile.width, tile.height, 1);
      for (int y = 0; y < tile.height; ++y)
        for (int x = 0; x < tile.width; ++x) {
          std::copy_n(tile.at(x, y), 3, pictures[i].at(x, y));
          *mattes[i].at(x, y) = tile.at(x, y)[3];
        }
      const auto slot = std::find(s.slot.begin(), s.slot.end(), static_cast<int>(i));
      FLOATSTAGE_CHECK(slot != s.slot.end(), "every camera in use is ranked");
      tiles.push_back({static_cast<int>(slot - s.slot.begin()), static_cast<int>(s.blocks[i].tile[0]),
                       static_cast<int>(s.blocks[i].tile[1]), &pictures[i], &mattes[i]});
    }
    return to.set(rig, s.mesh, tiles);
  }

  std::unique_ptr<ViewRenderer> linear_;
};

}  // namespace

double band_limit_of(const Scene::Impl& scene, std::size_t camera, const RendererOptions& options) {
  if (options.band_limit > 0) return options.band_limit;
  const RigCamera& c = scene.cameras[camera];
  const Eigen::Vector3d center = c.cam_from_world.center();
  std::vector<double> apart;
  for (const RigCamera& other : scene.cameras)
    apart.push_back((other.cam_from_world.center() - center).norm());
  std::sort(apart.begin(), apart.end());
  const double baseline = apart[std::min(apart.size(), static_cast<std::size_t>(options.cameras)) - 1];
  double nearest = options.nearest, farthest = options.farthest;
  if (farthest <= 0) {
    const double error = options.uncertainty * static_cast<double>(scene.box.diagonal().norm());
    const double depth = (c.cam_from_world * Eigen::Vector3d(scene.box.center().cast<double>())).z();
    nearest = std::max(depth - error, 0.1 * depth);
    farthest = depth + error;
  }
  if (!(nearest > 0)) return 0;  // the proxy is behind this camera: it shows nothing of it
  const double largest = std::max(c.model.width, c.model.height);
  // Before and behind the best plane (Eq. 9.13) disparities are alike: half of what lies between the ends.
  const double disparity = 0.5 * c.model.fx * baseline * (1 / nearest - 1 / farthest);
  return std::min(kUnfiltered * disparity, largest);
}

void band_limit(SceneTile& tile, double width) {
  if (width <= kUnfiltered) return;
  std::vector<float> rows = premultiplied(tile), both(rows.size());
  const std::vector<float> weights = taps(width);
  filter(rows, tile.width, tile.height, true, weights, both);
  filter(both, tile.width, tile.height, false, weights, rows);
  const float* sum = rows.data();
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x, sum += 4) put(sum, tile.at(x, y));
  tile.repeat_border();
}

void band_limit_reference(SceneTile& tile, double width) {
  if (width <= kUnfiltered) return;
  const std::vector<float> from = premultiplied(tile);
  const auto spacing = static_cast<float>(width / kUnfiltered);
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      float sum[4] = {0, 0, 0, 0}, total = 0;
      for (int v = 0; v < tile.height; ++v)
        for (int u = 0; u < tile.width; ++u) {
          const float w =
              mitchell(static_cast<float>(u - x) / spacing) * mitchell(static_cast<float>(v - y) / spacing);
          if (w == 0) continue;
          const float* p =
              from.data() + 4 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(tile.width) +
                                 static_cast<std::size_t>(u));
          for (int c = 0; c < 4; ++c) sum[c] += w * p[c];
          total += w;
        }
      for (float& s : sum) s /= total;
      put(sum, tile.at(x, y));
    }
  tile.repeat_border();
}

Result<std::unique_ptr<ViewRenderer>> make_band_limited_renderer(BackEnd back_end) {
  Result<std::unique_ptr<ViewRenderer>> linear = make_renderer("linear", back_end);
  if (!linear) return linear;
  return std::unique_ptr<ViewRenderer>(std::make_unique<BandLimitedRenderer>(std::move(*linear)));
}

}  // namespace floatstage::render
