#include "apps/viewer/play/path_editor.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace floatstage::apps {
namespace {

constexpr double kSame = 1e-3;  // seconds: keys that are nearer are one
constexpr std::size_t kMostSteps = 1000;

}  // namespace

void PathEditor::keep() {
  if (gesture_ == Gesture::Kept) return;
  if (gesture_ == Gesture::Begun) gesture_ = Gesture::Kept;
  if (before_.size() == kMostSteps) before_.erase(before_.begin());
  before_.push_back(path_);
  after_.clear();
}

void PathEditor::set(pipeline::CameraPath path) {
  keep();
  path_ = std::move(path);
  selected_.reset();
}

std::size_t PathEditor::put(pipeline::PathKey key, double time) {
  keep();
  key.time = time;
  std::vector<pipeline::PathKey>& keys = path_.keys;
  const auto after = std::find_if(keys.begin(), keys.end(),
                                  [&](const pipeline::PathKey& k) { return k.time > time - kSame; });
  const auto index = after - keys.begin();
  if (after != keys.end() && std::abs(after->time - time) <= kSame)
    *after = key;
  else
    keys.insert(after, key);
  return static_cast<std::size_t>(index);
}

std::size_t PathEditor::append(pipeline::PathKey key) {
  if (empty()) return put(key, 0);
  const pipeline::PathKey& last = path_.keys.back();
  double step = 1;
  if (key.take_time && last.take_time && *key.take_time != *last.take_time)
    step = std::abs(*key.take_time - *last.take_time);
  return put(key, last.time + step);
}

void PathEditor::remove(std::size_t index) {
  keep();
  path_.keys.erase(path_.keys.begin() + static_cast<std::ptrdiff_t>(index));
  selected_.reset();
}

void PathEditor::change(std::size_t index, pipeline::PathKey key) {
  key.time = path_.keys[index].time;
  if (key == path_.keys[index]) return;
  keep();
  path_.keys[index] = key;
}

void PathEditor::move(std::size_t index, double time) {
  std::vector<pipeline::PathKey>& keys = path_.keys;
  if (index + 1 < keys.size()) time = std::min(time, keys[index + 1].time - 2 * kSame);
  time = std::max(time, index > 0 ? keys[index - 1].time + 2 * kSame : 0.0);
  if (time == keys[index].time || (index + 1 < keys.size() && time >= keys[index + 1].time)) return;
  keep();
  keys[index].time = time;
}

void PathEditor::set_follow(std::size_t index, bool follow, const pipeline::SubjectTrack& subject) {
  pipeline::PathKey key = path_.keys[index];
  if (key.follow == follow) return;
  const Eigen::Vector3d centre = subject.at(take_time(path_, key.time));
  key.follow = follow;
  key.eye += follow ? Eigen::Vector3d(-centre) : centre;
  key.target += follow ? Eigen::Vector3d(-centre) : centre;
  change(index, key);
}

void PathEditor::undo() {
  if (before_.empty()) return;
  after_.push_back(std::exchange(path_, std::move(before_.back())));
  before_.pop_back();
}

void PathEditor::redo() {
  if (after_.empty()) return;
  before_.push_back(std::exchange(path_, std::move(after_.back())));
  after_.pop_back();
}

std::optional<std::size_t> PathEditor::selected() const {
  return selected_ && *selected_ < path_.keys.size() ? selected_ : std::nullopt;
}

}  // namespace floatstage::apps
