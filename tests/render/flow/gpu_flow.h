#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "render/gl/flow_compute.h"

namespace floatstage::render::test {

/// Pictures as the GPU's flow takes them: RG8UI, a layer a picture.
inline gl::Texture upload_pictures(std::span<const FlowImage> images) {
  gl::Texture texture;
  const int width = images[0].width, height = images[0].height;
  texture.reserve(GL_RG8UI, GL_NEAREST, width, height, static_cast<int>(images.size()));
  for (std::size_t i = 0; i < images.size(); ++i) {
    std::vector<std::uint8_t> pixels;
    for (int p = 0; p < width * height; ++p) {
      pixels.push_back(images[i].gray[p]);
      pixels.push_back(images[i].state == nullptr ? 255 : images[i].state[p]);
    }
    glTextureSubImage3D(texture.id(), 0, 0, 0, static_cast<GLint>(i), width, height, 1, GL_RG_INTEGER,
                        GL_UNSIGNED_BYTE, pixels.data());
  }
  return texture;
}

/// One layer of an array texture.
template <class T>
std::vector<T> layer_of(const gl::Texture& texture, int layer, int width, int height, int channels,
                        GLenum format, GLenum type) {
  std::vector<T> pixels(static_cast<std::size_t>(width * height * channels));
  glGetTextureSubImage(texture.id(), 0, 0, 0, layer, width, height, 1, format, type,
                       static_cast<GLsizei>(pixels.size() * sizeof(T)), pixels.data());
  return pixels;
}

/// Fields with the ways back that are among them.
inline std::vector<WantedField> wanted_fields(std::span<const FlowPair> pairs) {
  std::vector<WantedField> fields;
  for (const FlowPair& pair : pairs) {
    WantedField field{pair};
    for (std::size_t k = 0; k < pairs.size(); ++k)
      if (pairs[k].first == pair.second && pairs[k].second == pair.first) field.back = static_cast<int>(k);
    fields.push_back(field);
  }
  return fields;
}

/// A FlowEstimator's fields from the GPU, for tests and benches: pictures go up, fields come down.
class GpuFlow {
 public:
  GpuFlow(const FlowOptions& options, FlowPrecision precision, int fused = FlowCompute::kFused)
      : preset_(*variational_preset(options)),
        solver_(std::move(*FlowCompute::create(precision))),
        fused_(fused) {}

  std::vector<FlowField> estimate(std::span<const FlowImage> images, std::span<const FlowPair> pairs) {
    const int width = images[0].width, height = images[0].height;
    const gl::Texture pictures = upload_pictures(images);
    tables_.write(wanted_fields(pairs));
    solver_.solve(preset_, tables_, pictures, width, height, fused_);
    std::vector<FlowField> fields;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      FlowField field{
          width, height,
          layer_of<float>(solver_.fields(), static_cast<int>(k), width, height, 2, GL_RG, GL_FLOAT)};
      const std::uint8_t* state = images[pairs[k].first].state;
      for (std::size_t i = 0; state != nullptr && i < field.uv.size(); ++i)
        if (state[i / 2] == 0) field.uv[i] = 0;
      fields.push_back(std::move(field));
    }
    return fields;
  }
  const VariationalPreset& preset() const { return preset_; }
  const FlowCompute& solver() const { return solver_; }
  const FlowTables& tables() const { return tables_; }

 private:
  VariationalPreset preset_;
  FlowCompute solver_;
  FlowTables tables_;
  int fused_;
};

}  // namespace floatstage::render::test
