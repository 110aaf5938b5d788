#include "studio/node/camera_rack.h"

#include <map>

#include "core/check.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/text.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

std::string word_of(const std::string& spec) { return spec.substr(0, spec.find(':')); }

void add(const std::string& one, std::string& list) { list += (list.empty() ? "" : ", ") + one; }

}  // namespace

Result<CameraRack> CameraRack::make(const Rig& rig, const std::string& spec,
                                    std::vector<matting::KeySamples> samples) {
  FLOATSTAGE_CHECK(samples.size() == rig.cameras.size(), "samples of every camera");
  const std::vector<std::string> words =
      spec == "auto" ? matting::choose_keyers(samples) : std::vector(samples.size(), spec);
  CameraRack rack;
  std::string without_plate;
  std::vector<Image> stages;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const std::string& serial = rig.cameras[i].serial;
    if (words[i].empty())
      return fail(ErrorCode::NotFound, text("camera '", serial, "': ", matting::kNothingToKeyBy));
    const std::string word = word_of(words[i]);
    const bool compares = word == "plate" || word == "difference",
               shot = samples[i].empty_stage && !samples[i].pictures.empty();
    stages.push_back(compares && shot ? samples[i].pictures.front() : Image());
    if (compares && !shot) add(serial, without_plate);
    Result<CameraViewMaker> node =
        CameraViewMaker::make(serial, rig.cameras[i].model, words[i], std::move(samples[i]));
    if (!node) return forward(node);
    rack.nodes_.push_back(std::move(*node));
  }
  rack.shadows_ = StageShadows::of(rig, stages);
  if (!without_plate.empty())
    log::warning(text("no clean plate of ", without_plate,
                      ": what was seen first is taken for the empty stage; clear it and begin again, or give "
                      "plates"));
  return rack;
}

std::string CameraRack::keys() const {
  std::map<std::string, std::string> cameras;
  for (const CameraViewMaker& node : nodes_) add(node.serial(), cameras[word_of(node.spec())]);
  if (cameras.size() == 1) return cameras.begin()->first;
  std::string all;
  for (const auto& [word, serials] : cameras) add(text(word, " (", serials, ")"), all);
  return all;
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
  const std::vector<matting::CastShade>* shades =
      shadows_ ? &shadows_->look(set.images.frames, threads) : nullptr;
  times.key += milliseconds_of(now() - begun);
  parallel_for(nodes_.size(), threads, [&](std::size_t i) {
    const bool wanted = textured.empty() || textured[i];
    Result<std::shared_ptr<const CameraView>> view =
        nodes_[i].look(set.images.frames[i], set.instant, set.produced[i], wanted, quality,
                       shades != nullptr ? &(*shades)[i] : nullptr);
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
