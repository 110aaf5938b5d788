#include "render/gl/field_textures.h"

#include <algorithm>

namespace floatstage::render {

std::span<const int> FieldTextures::layers_of(std::span<const std::shared_ptr<const CameraField>> wanted) {
  int width = 0, height = 0, count = 0;
  for (const std::shared_ptr<const CameraField>& field : wanted) {
    if (!field) continue;
    width = std::max(width, field->width);
    height = std::max(height, field->height);
    ++count;
  }
  layers_.assign(wanted.size(), -1);
  if (count == 0) return layers_;
  ++now_;
  // Twice as many as a view needs: cameras come and go one by one.
  const int layers = std::max(fields_.layers(), 2 * count);
  if (fields_.reserve(GL_RG16_SNORM, GL_LINEAR, width, height, layers)) {
    held_.assign(static_cast<std::size_t>(layers), nullptr);
    used_.assign(held_.size(), 0);
  }
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    const auto found = std::find(held_.begin(), held_.end(), wanted[i]);
    if (found == held_.end()) continue;
    layers_[i] = static_cast<int>(found - held_.begin());
    used_[static_cast<std::size_t>(layers_[i])] = now_;
  }
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i] || layers_[i] >= 0) continue;
    const auto oldest =
        static_cast<std::size_t>(std::min_element(used_.begin(), used_.end()) - used_.begin());
    layers_[i] = static_cast<int>(oldest);
    held_[oldest] = wanted[i];
    used_[oldest] = now_;
    glTextureSubImage3D(fields_.id(), 0, 0, 0, layers_[i], wanted[i]->width, wanted[i]->height, 1, GL_RG,
                        GL_SHORT, wanted[i]->uv.data());
  }
  return layers_;
}

}  // namespace floatstage::render
