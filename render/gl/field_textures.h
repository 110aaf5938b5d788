#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/camera_fields.h"
#include "render/gl/gl_objects.h"

namespace floatstage::render {

/// The fields that views draw with, as layers of one texture: those of the views before stay where they are,
/// as far as there is room. GL thread.
class FieldTextures {
 public:
  /// Puts `wanted` there. Their layers, in order, until the next call; -1 for null.
  std::span<const int> layers_of(std::span<const std::shared_ptr<const CameraField>> wanted);

  /// Of all layers: RG16_SNORM, 1 being 32767 steps. Nothing before a first field was wanted.
  const gl::Texture& texture() const { return fields_; }

 private:
  gl::Texture fields_;
  std::vector<std::shared_ptr<const CameraField>> held_;  // a layer each; null: free
  std::vector<std::uint64_t> used_;                       // when
  std::vector<int> layers_;
  std::uint64_t now_ = 0;
};

}  // namespace floatstage::render
