#include "pipeline/matte/settle_added.h"

#include <algorithm>
#include <utility>

#include "capture/added_file.h"
#include "core/added_search.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/text.h"

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

std::vector<std::string> sentences(const capture::AddedFile& added) {
  std::vector<std::string> all;
  if (added.hidden) all = describe(added.cameras);
  for (std::string& s : all)
    s += " of the pictures were added by a camera or a converter, and are hidden (added.json; --added keep "
         "shows them)";
  return all;
}

Result<void> open_again(std::unique_ptr<capture::TakeReader>& take) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take->layout().folder());
  if (!opened) return forward(opened);
  take = std::move(*opened);
  return {};
}

}  // namespace

Result<std::vector<std::string>> settle_added(std::unique_ptr<capture::TakeReader>& take,
                                              std::optional<bool> hide, int threads) {
  const TakeLayout layout = take->layout();
  const bool known = is_there(capture::added_file(layout));
  Result<capture::AddedFile> before = capture::load_added(layout);
  if (!before) return forward(before);
  if (known && (!hide || *hide == before->hidden)) return sentences(*before);
  // Whatever is shown now is the recording itself: nothing is hidden yet, or it is not any more.
  capture::AddedFile now{.hidden = hide.value_or(true), .cameras = {}};
  if (now.hidden) {
    const std::vector<AddedContent> found = find_added(some_pictures(*take, threads));
    for (std::size_t i = 0; i < found.size(); ++i)
      if (!found[i].none()) now.cameras[take->rig().cameras[i].serial] = found[i];
  }
  if (Result<void> ok = capture::save_added(now, layout); !ok) return forward(ok);
  if (!now.cameras.empty() || !before->cameras.empty())
    if (Result<void> ok = open_again(take); !ok) return forward(ok);
  return sentences(now);
}

}  // namespace floatstage::pipeline
