#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/cpu/projection.h"
#include "render/flow.h"
#include "render/remembered_fields.h"
#include "render/scene.h"

namespace floatstage::render::cpu {

/// The fields of the picture before. A field between two photographs leads from where the proxy shows
/// something in one of them to where it shows it in the other: it is the surface's, whoever looks at it. So
/// what several views find of one scene are estimates of one thing, and their mean trembles less than each.
/// Looked up through the proxy; exponentially fading. The pass of render/gl/shaders/field_memory.comp. Keeps
/// its storage.
class FieldMemory {
 public:
  /// Mixes `share` of what was kept into the `fields` (flow_pair_at(), at 1/shrink) of a picture whose
  /// `projection` has run, where the picture before showed the same surface of the same scene drawn from the
  /// same two photographs (remembered_fields()). Fields towards images that are not `wanted` stay.
  void mix(const Scene& scene, const Projection& projection, const std::vector<bool>& wanted, int shrink,
           double share, std::span<FlowField> fields) const;
  /// The picture is drawn: it is the one before the next. Its `fields` are given for others of their size.
  void keep(const Scene& scene, const Projection& projection, const std::vector<bool>& wanted, int shrink,
            std::span<FlowField> fields);
  void forget() { scene_.reset(); }

 private:
  std::weak_ptr<void> scene_;  // its maps, which live as long as it does
  std::uint64_t version_ = 0;
  ViewRays rays_{};
  int width_ = 0, height_ = 0, shrink_ = 1;
  std::vector<float> inverse_z_;
  FieldsOfPicture picture_;
  std::vector<FlowField> fields_;
};

}  // namespace floatstage::render::cpu
