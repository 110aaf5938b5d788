#include "render/cpu/parallax_planes.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "render/cpu/covered.h"

namespace floatstage::render::cpu {
namespace {

constexpr int kBandsAThread = 4;  // rows show more of the proxy or less

}  // namespace

void SurfaceRow::resize(std::size_t padded) {
  for (std::vector<float>* list : {&x, &inverse_z, &nx, &ny, &nz})
    if (list->size() < padded) list->resize(padded, 1.F);
}

// Adds the row's parallaxes to those of the pixel that covers them.
void ParallaxPlanes::add_row(const Task& task, int y, Worker& worker, Parallaxes& out) {
  const SurfaceRow& row = worker.row;
  const std::size_t images = task.fade.size();
  PositionRow positions;
  positions.count = row.count;
  positions.cameras = static_cast<int>(images);
  positions.x = row.x.data();
  positions.y = static_cast<float>(y) + 0.5F;
  positions.inverse_z = row.inverse_z.data();
  positions.normals = {row.nx.data(), row.ny.data(), row.nz.data()};
  std::array<float*, kMostListed> x{}, v{};
  for (std::size_t i = 0; i < images; ++i) {
    worker.x[i].resize(row.x.size());
    worker.y[i].resize(row.x.size());
    x[i] = worker.x[i].data();
    v[i] = worker.y[i].data();
  }
  parallaxes_of_row(task.rays, task.centers, positions, x, v);
  const std::size_t line = static_cast<std::size_t>(y / task.shrink) * static_cast<std::size_t>(out.width);
  const auto column = [&](int k) {
    return static_cast<std::size_t>(static_cast<int>(row.x[static_cast<std::size_t>(k)]) / task.shrink);
  };
  for (int k = 0; k < row.count; ++k)
    out.offset[line + column(k)] += 1 / row.inverse_z[static_cast<std::size_t>(k)];
  for (std::size_t i = 0; i < images; ++i) {
    float *to_x = out.x[i].data() + line, *to_y = out.y[i].data() + line;
    for (int k = 0; k < row.count; ++k) {
      to_x[column(k)] += x[i][k];
      to_y[column(k)] += v[i][k];
    }
  }
}

// What the images of a pair are moved against one another becomes one pixel, in the mean.
void ParallaxPlanes::settle_row(int shrink, int y, Worker& worker, Parallaxes& out) {
  const std::size_t width = static_cast<std::size_t>(out.width), line = static_cast<std::size_t>(y) * width,
                    images = out.share.size();
  std::vector<float>& scale = worker.scale;
  scale.assign(width, 0.F);
  float pairs = 0;
  for (std::size_t i = 0; i < images; ++i)
    for (std::size_t j = i + 1; j < images; ++j) {
      const float both = out.share[i] * out.share[j];
      pairs += both;
      add_distances(width, both, {out.x[i].data() + line, out.y[i].data() + line},
                    {out.x[j].data() + line, out.y[j].data() + line}, scale.data());
    }
  for (float& apart : scale) apart = apart > 0 ? pairs / apart : 0.F;
  for (std::size_t i = 0; i < images; ++i)
    for (float* plane : {out.x[i].data() + line, out.y[i].data() + line})
      for (std::size_t k = 0; k < width; ++k) plane[k] *= scale[k];
  // Sums over a pixel's parts, like those of the parallaxes, whose mean is for one unit of offset over depth.
  float* offset = out.offset.data() + line;
  for (std::size_t k = 0; k < width; ++k) offset[k] *= static_cast<float>(shrink) * scale[k];
}

void ParallaxPlanes::run(const Task& task, const ReadRow& read, Parallaxes& out) {
  out.width = (task.width + task.shrink - 1) / task.shrink;
  out.height = (task.height + task.shrink - 1) / task.shrink;
  const std::size_t images = task.fade.size(),
                    size = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  out.x.resize(images);
  out.y.resize(images);
  out.share = task.fade;
  float all = 0;
  for (const float fade : task.fade) all += fade;
  for (float& share : out.share) share = all > 0 ? share / all : 1 / static_cast<float>(images);
  const int threads = task.threads > 0 ? task.threads : default_threads(),
            bands = std::max(1, std::min(out.height, kBandsAThread * threads));
  if (workers_.size() < static_cast<std::size_t>(bands)) workers_.resize(static_cast<std::size_t>(bands));
  out.offset.assign(size, 0.F);
  for (std::size_t i = 0; i < images; ++i) {
    out.x[i].assign(size, 0.F);
    out.y[i].assign(size, 0.F);
  }
  const std::size_t padded = static_cast<std::size_t>(task.width + 2 * Covered::kAlign);
  parallel_for(static_cast<std::size_t>(bands), task.threads, [&](std::size_t band) {
    Worker& worker = workers_[band];
    worker.row.resize(padded);
    const int at = static_cast<int>(band);
    for (int y = out.height * at / bands; y < out.height * (at + 1) / bands; ++y) {
      for (int v = y * task.shrink; v < std::min((y + 1) * task.shrink, task.height); ++v) {
        read(v, worker.row);
        if (worker.row.count > 0) add_row(task, v, worker, out);
      }
      settle_row(task.shrink, y, worker, out);
    }
  });
}

}  // namespace floatstage::render::cpu
