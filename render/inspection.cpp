#include "render/inspection.h"

#include <algorithm>

#include "core/text.h"
#include "render/scene_impl.h"

namespace floatstage::render {

bool is_shared_intermediate(RenderOutput output) {
  switch (output) {
    case RenderOutput::Weights:
    case RenderOutput::Visibility:
    case RenderOutput::SoftVisibility:
    case RenderOutput::Depth:
    case RenderOutput::Opacity:
    case RenderOutput::Projected:
    case RenderOutput::Aliasing:
    case RenderOutput::Predicted:
      return true;
    default:
      return false;
  }
}

bool can_show(std::string_view renderer, RenderOutput output) {
  if (renderer == "floating") return true;
  if (renderer == "light-field")
    return output == RenderOutput::Color || output == RenderOutput::Ghosting ||
           output == RenderOutput::Depth || output == RenderOutput::Opacity;
  return output < RenderOutput::Warped && (output != RenderOutput::Flow || renderer == "floating-static");
}

Result<void> check_output(std::string_view renderer, RenderOutput output) {
  if (can_show(renderer, output)) return {};
  std::string others;
  for (std::size_t i = 0; i < render_output_names().size(); ++i)
    if (can_show(renderer, static_cast<RenderOutput>(i)))
      others += text(others.empty() ? "" : ", ", render_output_names()[i]);
  return fail(
      ErrorCode::InvalidArgument,
      text("the renderer '", renderer, "' has no '", render_output_names()[static_cast<std::size_t>(output)],
           "' to show; choose ", others, ", or the renderer 'floating', which has all"));
}

bool lacks_shown_camera(const RenderedView& view, const RendererOptions& options) {
  const auto lacks = [&](int camera) {
    return camera >= 0 && std::find(view.cameras.begin(), view.cameras.end(), camera) == view.cameras.end();
  };
  switch (options.output) {
    case RenderOutput::Field:
    case RenderOutput::Confidence:
      return lacks(options.shown_camera) || lacks(options.towards_camera);
    case RenderOutput::Flow:
    case RenderOutput::Projected:
    case RenderOutput::Warped:
      return lacks(options.shown_camera);
    default:
      return false;
  }
}

ShownSlots shown_slots(const Scene& scene, const CameraChoice& choice, const RendererOptions& options) {
  const std::vector<int>& rig_index = scene.impl().rig_index;
  const auto slot_of = [&](int camera) {
    for (std::size_t i = 0; i < choice.chosen; ++i)
      if (rig_index[static_cast<std::size_t>(choice.listed[i])] == camera) return static_cast<int>(i);
    return -1;
  };
  ShownSlots slots;
  slots.camera = options.shown_camera < 0 ? 0 : slot_of(options.shown_camera);
  if (options.towards_camera >= 0)
    slots.towards = slot_of(options.towards_camera);
  else if (choice.chosen > 1)
    slots.towards = slots.camera == 0 ? 1 : 0;
  if (slots.towards == slots.camera) slots.towards = -1;
  return slots;
}

}  // namespace floatstage::render
