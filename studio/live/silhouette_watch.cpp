#include "studio/live/silhouette_watch.h"

#include <algorithm>

#include "capture/recorder.h"
#include "core/give_way.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

constexpr int kNice = 10;  // starved it would say nothing where the machine is too slow
constexpr int kSteps = 2;  // sightings in a row

}  // namespace

std::string SilhouetteNews::remark() const {
  std::string all;
  for (const std::string& doubt : doubts) all += (all.empty() ? "" : "; ") + doubt;
  return all;
}

SilhouetteWatch::SilhouetteWatch(const Rig& rig, const std::string& key, Nanoseconds rest)
    : rig_(rig), findings_(rig, key), rest_(rest) {
  thread_ = std::thread([this] { run(); });
}

SilhouetteWatch::~SilhouetteWatch() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool SilhouetteWatch::offer(std::span<const Silhouette> outlines, std::span<const Frame> photographs) {
  {
    const std::lock_guard lock(mutex_);
    if (full_ || now() < rested_) return false;
    outlines_.assign(outlines.begin(), outlines.end());
    photographs_.clear();
    if (shows_)  // copies, so that no camera waits for its buffers
      for (const Frame& frame : photographs)
        photographs_.push_back(frame.empty() ? Frame() : capture::detached(frame));
    full_ = true;
  }
  changed_.notify_all();
  return true;
}

std::shared_ptr<const SilhouetteNews> SilhouetteWatch::news() const {
  const std::lock_guard lock(mutex_);
  return news_;
}

std::uint64_t SilhouetteWatch::judged() const {
  const std::lock_guard lock(mutex_);
  return judged_;
}

void SilhouetteWatch::run() {
  give_way(kNice);
  std::vector<Silhouette> outlines;
  std::vector<Image> rgb;
  for (;;) {
    std::vector<Frame> photographs;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return full_ || stopping_; });
      if (stopping_) return;
      outlines.swap(outlines_);
      photographs.swap(photographs_);
    }
    const bool changed = note(findings_.of(outlines));
    rgb.clear();
    for (const Frame& frame : photographs) {
      Result<Image> picture = frame.empty() ? Result<Image>(Image()) : to_rgb(frame);
      rgb.push_back(picture ? std::move(*picture) : Image());
    }
    if (changed || !rgb.empty()) tell(rgb);
    const std::lock_guard lock(mutex_);
    ++judged_;
    rested_ = now() + rest_;
    full_ = false;
  }
}

// Whether something else is to be said than before.
bool SilhouetteWatch::note(std::vector<SilhouetteFinding> found) {
  bool changed = false;
  for (auto& [what, known] : known_)
    if (std::none_of(found.begin(), found.end(), [&](const auto& f) { return f.what == what; }) &&
        --known.steps <= 0)
      changed |= known.said;
  std::erase_if(known_, [](const auto& entry) { return entry.second.steps <= 0; });
  for (SilhouetteFinding& finding : found) {
    Said& known = known_[finding.what];
    known.steps = std::min(known.steps + 1, kSteps);
    if (known.said) continue;
    known.said = known.steps == kSteps;
    changed |= known.said;
    known.finding = std::move(finding);
  }
  return changed;
}

// Pictures are asked for once something is to be said, and come with a later instant.
void SilhouetteWatch::tell(const std::vector<Image>& rgb) {
  auto news = std::make_shared<SilhouetteNews>();
  std::vector<int> cameras;
  for (const auto& [what, known] : known_) {
    if (!known.said) continue;
    news->doubts.push_back(known.finding.sentence);
    cameras.insert(cameras.end(), known.finding.cameras.begin(), known.finding.cameras.end());
  }
  std::sort(cameras.begin(), cameras.end());
  cameras.erase(std::unique(cameras.begin(), cameras.end()), cameras.end());
  for (const int c : cameras) news->cameras.push_back(rig_.cameras[static_cast<std::size_t>(c)].serial);
  news->picture = findings_.picture(cameras, rgb);
  const std::lock_guard lock(mutex_);
  shows_ = !news->doubts.empty() && news->picture.empty();
  news_ = std::move(news);
}

}  // namespace floatstage::studio
