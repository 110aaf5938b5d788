#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/gl/kernel.h"
#include "render/gl/projection.h"
#include "render/remembered_fields.h"

namespace floatstage::render {

/// cpu::FieldMemory on the GPU: the fields of the picture before, for the next of the same scene. GL thread.
class FieldMemory {
 public:
  static Result<FieldMemory> create();

  /// The `flows` (layers as flow_pair_at()) of a picture whose `projection` has run, with `share` of what was
  /// kept in them; and keeps those. Towards images that are not `wanted` nothing is kept. Valid until the
  /// next call.
  const gl::Texture& mix(const Scene& scene, const View& view, const Projection& projection,
                         const std::vector<bool>& wanted, int shrink, double share, const gl::Texture& flows);
  void forget() { scene_.reset(); }

 private:
  FieldMemory() = default;
  bool knows(const Scene& scene, int shrink) const;

  gl::Kernel pass_;
  gl::Buffer uniforms_;
  std::size_t uniform_capacity_ = 0;
  std::array<gl::Texture, 2> fields_;  // what is kept, and what it is mixed into, in turns
  std::size_t kept_ = 0;
  gl::Texture surface_;
  std::weak_ptr<void> scene_;  // its textures, which live as long as it does
  std::uint64_t version_ = 0;
  View view_;
  Window window_;
  int shrink_ = 1;
  FieldsOfPicture picture_;
};

}  // namespace floatstage::render
