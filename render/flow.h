#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "render/interruption.h"

namespace floatstage::render {

/// A picture for flow estimation: one grey plane, 0…255, rows top first.
struct FlowImage {
  int width = 0, height = 0;
  const std::uint8_t* gray = nullptr;  ///< width*height, tightly packed; not owned
  /// What the pixels are worth, width*height, as ProjectedImages::state: 255 is evidence, 0 lies outside the
  /// picture's content, anything else is content but no evidence. Null: all is evidence.
  const std::uint8_t* state = nullptr;
};

/// Which picture is looked from, and which one into: indices into a list of pictures.
struct FlowPair {
  std::size_t first = 0, second = 1;
};

/// Displacements in px: first(x, y) looks like second(x + u, y + v). Interleaved u, v.
struct FlowField {
  int width = 0, height = 0;
  std::vector<float> uv;  ///< 2 * width * height
};

/// Where the OpenGL back-end solves the variational flow.
enum class FlowPlace {
  Auto,  ///< Gpu, but Cpu where OpenGL is software
  Cpu,
  Gpu,
};

struct FlowOptions {
  std::string backend = "variational";  ///< see flow_backends(); "none": nothing moves (no estimator)
  std::string preset;  ///< empty: the back-end's own. variational: "fast", "quality"; dis: "medium", "fast",
                       ///< "ultrafast"
  int finest_scale = 0;  ///< level at which the search stops; 0 is full resolution, 1 half, …
  int iterations = 0;    ///< variational: warps at the finest level, one more at each coarser one up to the
                         ///< preset's most; dis: of its search. 0: the preset's own
  int refinement = 20;   ///< dis: iterations of its variational refinement (not for "ultrafast")
  int shrink = 1;        ///< the pictures are reduced by this factor first, 1 … 8: much faster, softer
  FlowPlace place = FlowPlace::Auto;  ///< variational, drawn by OpenGL; estimators are always on the CPU
  bool operator==(const FlowOptions&) const = default;
};

/// Estimates optical flow on the CPU. Deterministic, at any thread count; used by one thread at a time. Keeps
/// its memory: use one for many pictures.
class FlowEstimator {
 public:
  virtual ~FlowEstimator() = default;
  /// The fields of `pairs` of `images`, all of one size, into `result` (one a pair, in their order; memory in
  /// them is used again). `initial` is empty or has one field a pair to start from, which may have no pixels
  /// (none known); it is only read and may not be `result`. On up to `threads` threads (0: one per core).
  /// InvalidArgument for empty pictures, different sizes or lists that do not fit together.
  virtual Result<void> estimate(std::span<const FlowImage> images, std::span<const FlowPair> pairs,
                                std::span<const FlowField> initial, int threads,
                                std::span<FlowField> result) = 0;
  /// Whose answer ends estimates early, as Cancelled, where the estimator looks ("variational": between
  /// pairs); outlives them. Null: nobody's.
  void watch(Interruption* interruption) { interruption_ = interruption; }

 protected:
  bool given_up() const { return interruption_ != nullptr && interruption_->given_up(); }

 private:
  Interruption* interruption_ = nullptr;
};

/// Brightness of a picture of 1, 3 or 4 channels (Rec. 601), width*height; its alpha is not looked at.
std::vector<std::uint8_t> flow_gray(const Image& picture);

/// The field of one pair, from nothing, on this thread.
Result<FlowField> estimate_flow(FlowEstimator& estimator, const FlowImage& first, const FlowImage& second);

/// What every back-end refuses.
Result<void> check_flow_input(std::span<const FlowImage> images, std::span<const FlowPair> pairs,
                              std::span<const FlowField> initial, std::span<const FlowField> result);

Result<std::unique_ptr<FlowEstimator>> make_flow_estimator(const FlowOptions& options);
std::vector<std::string> flow_backends();

}  // namespace floatstage::render
