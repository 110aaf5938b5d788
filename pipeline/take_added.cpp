#include "pipeline/take_added.h"

#include <algorithm>

#include "core/added_search.h"
#include "core/parallel.h"

namespace floatstage::pipeline {
namespace {

constexpr int kInstants = 3, kInstantsOfFew = 12;
constexpr std::size_t kFewCameras = 3;
constexpr double kMostBytes = 600e6;  // of pictures held at once

// The same instants of all cameras, as far as they can be read.
std::vector<std::vector<Image>> some_pictures(capture::TakeReader& take, int threads) {
  const std::vector<RigCamera>& cameras = take.rig().cameras;
  double bytes = 1;  // of one instant
  for (const RigCamera& c : cameras) bytes += 3.0 * c.model.width * c.model.height;
  const int wanted = cameras.size() < kFewCameras ? kInstantsOfFew : kInstants;
  const int count = std::min({take.frame_count(), wanted, std::max(1, static_cast<int>(kMostBytes / bytes))});
  std::vector<std::vector<Image>> pictures(cameras.size());
  parallel_for(cameras.size(), threads, [&](std::size_t i) {
    for (int k = 0; k < count; ++k) {
      const int instant = static_cast<int>((2L * k + 1) * take.frame_count() / (2L * count));
      const Result<Frame> frame = take.frame(static_cast<int>(i), instant);
      if (!frame || frame->empty()) continue;
      if (Result<Image> rgb = to_rgb(*frame)) pictures[i].push_back(std::move(*rgb));
    }
  });
  return pictures;
}

}  // namespace

capture::AddedFile search_added(capture::TakeReader& take, int threads) {
  capture::AddedFile added;
  const std::vector<AddedContent> found = find_added(some_pictures(take, threads));
  for (std::size_t i = 0; i < found.size(); ++i)
    if (!found[i].none()) added.cameras[take.rig().cameras[i].serial] = found[i];
  return added;
}

}  // namespace floatstage::pipeline
