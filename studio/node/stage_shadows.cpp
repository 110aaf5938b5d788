#include "studio/node/stage_shadows.h"

#include <algorithm>
#include <utility>

#include "core/parallel.h"

namespace floatstage::studio {
namespace {

constexpr int kLongest = 160;                // px of a side that is looked at
constexpr std::ptrdiff_t kFewestStages = 3;  // one is asked, two have to agree

}  // namespace

std::optional<StageShadows> StageShadows::of(const Rig& rig, const std::vector<Image>& stages) {
  std::vector<Camera> cameras(rig.cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraModel& m = rig.cameras[i].model;
    Camera& camera = cameras[i];
    camera.width = m.width;
    camera.height = m.height;
    camera.factor = std::max(1, (std::max(m.width, m.height) + kLongest - 1) / kLongest);
    const Image& stage = stages[i];
    if (stage.channels != 3 || stage.width != m.width || stage.height != m.height) continue;
    if (Result<Image> small = shrink(make_frame({}, stage), camera.factor)) camera.stage = std::move(*small);
  }
  const auto known =
      std::count_if(cameras.begin(), cameras.end(), [](const Camera& c) { return !c.stage.empty(); });
  if (known < kFewestStages) return std::nullopt;
  return StageShadows(rig, std::move(cameras));
}

const std::vector<matting::CastShade>& StageShadows::look(const std::vector<Frame>& frames, int threads) {
  parallel_for(cameras_.size(), threads, [&](std::size_t i) {
    Camera& camera = cameras_[i];
    const Frame& frame = frames[i];
    before_[i] = {};
    if (camera.stage.empty() || frame.empty() || frame.info.status != FrameStatus::Ok ||
        frame.layout.width != camera.width || frame.layout.height != camera.height ||
        frame.layout.format == PixelFormat::Gray8)
      return;
    if (shrink(frame, camera.factor, camera.sums, camera.picture))
      before_[i] = {&camera.picture, &camera.stage};
  });
  return shadows_.find(before_, threads);
}

}  // namespace floatstage::studio
