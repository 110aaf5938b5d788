#include "calib/live_calibration.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/check.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::calib {

LiveCalibration::LiveCalibration(LiveTarget target, std::vector<CalibrationCamera> cameras)
    : target_(std::move(target)), last_(cameras.size()) {
  observations_.cameras = std::move(cameras);
  observations_.targets.push_back(make_target(target_.design, "target", target_.wand_sigma));
}

bool LiveCalibration::is_new(const std::vector<Detection>& detections) const {
  if (target_.least_move <= 0) return true;
  for (std::size_t c = 0; c < detections.size(); ++c) {
    const std::vector<SeenPoint>&now = detections[c].points, &before = last_[c].points;
    if (now.empty()) continue;
    double sum = 0;
    int count = 0;
    for (const SeenPoint& p : now) {
      const auto same =
          std::find_if(before.begin(), before.end(), [&](const SeenPoint& q) { return q.id == p.id; });
      if (same == before.end()) continue;
      sum += (p.pixel - same->pixel).norm();
      ++count;
    }
    if (2 * count < static_cast<int>(now.size()) ||
        sum / count > target_.least_move * observations_.cameras[c].width)
      return true;
  }
  return false;
}

Result<LiveInstant> LiveCalibration::look(const FrameSet& set) const {
  FLOATSTAGE_CHECK(set.frames.size() == observations_.cameras.size(), "one frame a camera");
  LiveInstant out{
      .time = set.time, .detections = std::vector<Detection>(set.frames.size()), .counted = false};
  std::vector<Result<void>> results(set.frames.size());
  parallel_for(set.frames.size(), target_.threads, [&](std::size_t c) {
    const Frame& frame = set.frames[c];
    const CalibrationCamera& camera = observations_.cameras[c];
    if (frame.empty() || frame.info.status != FrameStatus::Ok) {
      out.detections[c] = {{}, DetectionFailure::Unreadable, "the camera missed this instant"};
      return;
    }
    const Result<Image> image = to_rgb(frame);
    if (!image) {
      results[c] = fail(image.error().code, text("camera '", camera.serial, "': ", image.error().message));
      return;
    }
    if (image->width != camera.width || image->height != camera.height) {
      results[c] =
          fail(ErrorCode::BadData, text("camera '", camera.serial, "': its picture is ", image->width, "x",
                                        image->height, ", not ", camera.width, "x", camera.height));
      return;
    }
    // Why nothing was found is for pictures that stay: the search for it takes longer than the next picture.
    out.detections[c] = detect(target_.design, *image, {.diagnose = false});
  });
  for (const Result<void>& r : results)
    if (!r) return forward(r);
  return out;
}

void LiveCalibration::keep(const FrameSet& set, LiveInstant& out) {
  const int frame = sets_++;
  const bool any = std::any_of(out.detections.begin(), out.detections.end(),
                               [](const Detection& d) { return !d.points.empty(); });
  if (!any || !is_new(out.detections)) return;
  out.counted = true;
  ++counted_;
  last_ = out.detections;
  for (std::size_t c = 0; c < out.detections.size(); ++c)
    if (!out.detections[c].points.empty())
      observations_.views.push_back({.camera = static_cast<int>(c),
                                     .target = 0,
                                     .frame = frame,
                                     .time = set.frames[c].info.exposure_start,
                                     .points = out.detections[c].points});
}

Observations thinned(const Observations& o, int frames) {
  std::map<int, int> cameras;  // of each frame
  for (const TargetView& v : o.views) ++cameras[v.frame];
  if (static_cast<int>(cameras.size()) <= frames) return o;
  std::vector<std::pair<int, int>> order(cameras.begin(), cameras.end());
  // Evenly in time within each number of cameras, the most first.
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::set<int> kept;
  for (std::size_t i = 0; i < order.size() && static_cast<int>(kept.size()) < frames;) {
    std::size_t end = i;
    while (end < order.size() && order[end].second == order[i].second) ++end;
    const std::size_t room = std::min(end - i, static_cast<std::size_t>(frames) - kept.size());
    // Frames of one camera alone tell about its lens: they get a third of the room.
    const std::size_t share =
        order[i].second > 1 ? std::min(room, std::max<std::size_t>(
                                                 1, (static_cast<std::size_t>(frames) - kept.size()) * 2 / 3))
                            : room;
    for (std::size_t k = 0; k < share; ++k) kept.insert(order[i + k * (end - i) / share].first);
    i = end;
  }
  Observations out = o;
  std::erase_if(out.views, [&](const TargetView& v) { return !kept.contains(v.frame); });
  return out;
}

}  // namespace floatstage::calib
