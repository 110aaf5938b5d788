#include "studio/node/camera_rack.h"

#include "core/check.h"
#include "core/parallel.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {

Result<CameraRack> CameraRack::make(const Rig& rig, const std::string& spec,
                                    std::vector<std::vector<Image>> samples) {
  FLOATSTAGE_CHECK(samples.size() == rig.cameras.size(), "samples of every camera");
  CameraRack rack;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    Result<CameraViewMaker> node =
        CameraViewMaker::make(rig.cameras[i].serial, rig.cameras[i].model, spec, std::move(samples[i]));
    if (!node) return forward(node);
    rack.nodes_.push_back(std::move(*node));
  }
  return rack;
}

Result<void> CameraRack::prepare(int shrink) {
  for (CameraViewMaker& node : nodes_)
    if (Result<void> ok = node.prepare(shrink); !ok) return ok;
  return {};
}

void CameraRack::look(const TimedSet& set, const std::vector<bool>& textured, const NodeQuality& quality,
                      int threads, SceneTimes& times, std::vector<std::shared_ptr<const CameraView>>& views) {
  const Timestamp begun = now();
  views.assign(nodes_.size(), nullptr);
  troubles_.resize(nodes_.size());
  parallel_for(nodes_.size(), threads, [&](std::size_t i) {
    const bool wanted = textured.empty() || textured[i];
    Result<std::shared_ptr<const CameraView>> view =
        nodes_[i].look(set.images.frames[i], set.instant, set.produced[i], wanted, quality);
    if (view) {
      views[i] = std::move(*view);
      troubles_[i].clear();
    } else {
      troubles_[i] = view.error().message;
    }
  });
  trouble_.clear();
  for (const std::string& trouble : troubles_)
    if (trouble_.empty()) trouble_ = trouble;
  for (const CameraViewMaker& node : nodes_) {
    times.key += node.timings().key;
    times.outline += node.timings().outline;
    times.tile += node.timings().tile;
  }
  times.nodes = milliseconds_of(now() - begun);
}

}  // namespace floatstage::studio
