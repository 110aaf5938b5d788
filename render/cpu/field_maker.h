#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "render/camera_fields.h"
#include "render/cpu/projection.h"
#include "render/pairwise_flows.h"

namespace floatstage::render::cpu {

/// Estimates the fields of "floating-static" in the cameras' own pictures (Eq. 11.4). A pair's field depends
/// on its two photographs, the mesh and the flow's options alone. Keeps its memory; one thread at a time.
class FieldMaker {
 public:
  /// Puts the fields of these pairs into `made`. Of the options the flow and the threads count, and who gives
  /// it up: Cancelled, with `made` as it was. InvalidArgument for a camera without a picture.
  Result<void> run(const Scene& scene, std::span<const CameraPair> pairs, const RendererOptions& options,
                   FieldSet& made);

 private:
  struct Job {
    CameraPair pair;
    ProjectedImages images;
    CameraField field;
  };
  Result<void> project(const Scene& scene, const RendererOptions& options, Job& job);

  Projection projection_;
  std::vector<Job> jobs_;
  std::vector<PairwiseFlows> workers_;
};

/// From each slot of a view's list to each, at kMostListed * from + to; null: nothing moves.
using ChosenFields =
    std::array<std::shared_ptr<const CameraField>, static_cast<std::size_t>(kMostListed) * kMostListed>;

/// The fields between the photographs that are chosen for a view: those that the scene was given, those that
/// were made before, and the rest made now by `maker` and kept as long as the scene is not set anew.
Result<ChosenFields> chosen_fields(const Scene& scene, const CameraChoice& choice,
                                   const RendererOptions& options, FieldMaker& maker);

}  // namespace floatstage::render::cpu
