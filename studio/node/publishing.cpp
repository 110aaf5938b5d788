#include "studio/node/publishing.h"

#include "core/log.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

// The cameras of this node, of all that stand around the stage.
Result<Rig> rig_of_node(const CaptureConfig& config) {
  const Result<Rig> studio = load_rig(config.rig);
  if (!studio) return studio;
  Rig rig;
  for (const CaptureConfig::Camera& camera : config.cameras) {
    const int index = camera_index(*studio, camera.serial);
    if (index < 0)
      return fail(ErrorCode::NotFound, text(config.rig.string(), ": camera '", camera.serial,
                                            "' is not in it; calibrate again or correct the serial"));
    rig.cameras.push_back(studio->cameras[static_cast<std::size_t>(index)]);
  }
  return rig;
}

}  // namespace

Result<std::unique_ptr<PublishingNode>> publish(CaptureNode& node) {
  const CaptureConfig& config = node.config();
  if (!config.publish) return std::unique_ptr<PublishingNode>();
  const CaptureConfig::Publish& wanted = *config.publish;
  const Result<Rig> rig = rig_of_node(config);
  if (!rig) return forward(rig);
  PublishingOptions options;
  options.publisher.address = wanted.address;
  options.publisher.tiles = {wanted.raw_tiles ? wire::TileCode::Raw : wire::TileCode::Jpeg,
                             wanted.jpeg_quality};
  if (!wanted.keys.empty()) {
    Result<wire::StudioKeys> keys = wire::load_keys(wanted.keys);
    if (!keys) return forward(keys);
    options.publisher.keys = std::move(*keys);
  }
  options.control = wanted.control;
  options.key = wanted.key;
  options.plates = wanted.plates;
  options.quality.shrink = wanted.shrink;
  options.offsets = capture::offsets_of(config.recorder.times, *rig);
  Result<std::unique_ptr<PublishingNode>> telling =
      PublishingNode::open(*rig, config.frame_rate, options, node);
  if (!telling) return telling;
  node.add_tap([to = telling->get()](const Frame& frame) { to->push(frame, now()); });
  log::info(text("outlines at ", (*telling)->address(), ", requests at ", (*telling)->control_address()));
  return telling;
}

}  // namespace floatstage::studio
