#include "studio/live/view_gatherer.h"

#include <algorithm>

#include "core/text.h"

namespace floatstage::studio {
namespace {

// More than any wait needs; a node whose clock runs wild does not fill the memory.
constexpr std::size_t kMostOpen = 64;
// A clock is off when its camera was missing so often in a row, always by the same time.
constexpr int kSure = 5;
constexpr std::size_t kRemembered = 64;  // more than come while an instant waits
constexpr Nanoseconds kSame = milliseconds(1);

Nanoseconds magnitude(Nanoseconds d) { return d < Nanoseconds{0} ? Nanoseconds{-d.count} : d; }

}  // namespace

ViewGatherer::ViewGatherer(std::vector<std::string> serials, const GatherOptions& options)
    : serials_(std::move(serials)), options_(options), heard_(serials_.size()), clocks_(serials_.size()) {}

// The open set that is meant by an instant, or the end.
ViewGatherer::Sets::iterator ViewGatherer::set_of(Timestamp instant) {
  const auto after = open_.lower_bound(instant);
  auto best = open_.end();
  Nanoseconds least = options_.tolerance + Nanoseconds{1};
  const auto consider = [&](Sets::iterator it, Nanoseconds distance) {
    if (distance >= least) return;
    least = distance;
    best = it;
  };
  if (after != open_.end()) consider(after, after->first - instant);
  if (after != open_.begin()) consider(std::prev(after), instant - std::prev(after)->first);
  return best;
}

void ViewGatherer::push(std::shared_ptr<const CameraView> view, Timestamp now) {
  ++counters_.views;
  const auto serial = std::find(serials_.begin(), serials_.end(), view->serial);
  if (serial == serials_.end()) {
    ++counters_.unknown_cameras;
    return;
  }
  const auto camera = static_cast<std::size_t>(serial - serials_.begin());
  Clock& clock = clocks_[camera];
  const Nanoseconds age = now - view->instant;
  if (age > options_.behind || age < Nanoseconds{-options_.ahead.count}) {
    ++counters_.off_clock;
    clock.off = Nanoseconds{-age.count};
    clock.times = kSure;
    clock.instants.clear();
    return;
  }
  clock.instants.push_back(view->instant);
  if (clock.instants.size() > kRemembered) clock.instants.pop_front();
  heard_[camera] = now;
  if (gone_ && view->instant <= *gone_ + options_.tolerance) {
    ++counters_.late;
    return;
  }
  auto at = set_of(view->instant);
  if (at == open_.end()) {
    Open open;
    open.begun = now;
    open.set.instant = view->instant;
    open.set.first_produced = view->produced;
    open.set.views.resize(serials_.size());
    at = open_.emplace(view->instant, std::move(open)).first;
  }
  Open& open = at->second;
  if (!open.set.views[camera]) ++open.here;
  if (view->known && (open.here == 1 || view->produced < open.set.first_produced))
    open.set.first_produced = view->produced;
  open.set.views[camera] = std::move(view);
  if (open_.size() > kMostOpen) {
    open_.erase(open_.begin());
    ++counters_.overtaken;
  }
}

bool ViewGatherer::is_settled(const Open& open, Timestamp now) const {
  if (open.here == serials_.size() || now - open.begun >= options_.longest_wait) return true;
  for (std::size_t camera = 0; camera < serials_.size(); ++camera) {
    const bool speaks = heard_[camera] && now - *heard_[camera] < options_.silence;
    if (!open.set.views[camera] && speaks) return false;
  }
  return true;
}

// How far are the instants of those that are missing here? The first camera that speaks says what the time
// is.
void ViewGatherer::compare_clocks(const GatheredViews& set, Timestamp now) {
  const auto first = std::find_if(heard_.begin(), heard_.end(), [&](const auto& heard) {
    return heard && now - *heard < options_.silence;
  });
  if (first == heard_.end() || !set.views[static_cast<std::size_t>(first - heard_.begin())]) return;
  for (std::size_t camera = 0; camera < clocks_.size(); ++camera) {
    Clock& clock = clocks_[camera];
    if (set.views[camera]) {
      clock.off.reset();
      clock.times = 0;
    }
    if (set.views[camera] || clock.instants.empty()) continue;
    const auto nearer = [&](Timestamp a, Timestamp b) {
      return magnitude(a - set.instant) < magnitude(b - set.instant);
    };
    const Nanoseconds off =
        *std::min_element(clock.instants.begin(), clock.instants.end(), nearer) - set.instant;
    // A larger one is of an instant whose own one was left out.
    if (clock.off && magnitude(off) > magnitude(*clock.off) + kSame) continue;
    const bool same = clock.off && magnitude(off - *clock.off) <= kSame;
    clock.times = same ? clock.times + 1 : 1;
    clock.off = off;
  }
}

std::string ViewGatherer::remark() const {
  std::string who;
  Nanoseconds off;
  for (std::size_t camera = 0; camera < clocks_.size(); ++camera) {
    if (!clocks_[camera].off || clocks_[camera].times < kSure) continue;
    who += (who.empty() ? "" : ", ") + serials_[camera];
    off = *clocks_[camera].off;
  }
  if (who.empty()) return who;
  const std::int64_t ms = (magnitude(off).count + 500'000) / 1'000'000;
  return text(
      who, ": ", ms, " ms ", off < Nanoseconds{0} ? "before" : "after",
      " the other cameras, and left out of their instants; make the clocks of all machines agree (PTP)");
}

std::optional<GatheredViews> ViewGatherer::newest(Timestamp now) {
  const auto settled = std::find_if(open_.rbegin(), open_.rend(),
                                    [&](const auto& entry) { return is_settled(entry.second, now); });
  if (settled == open_.rend()) return std::nullopt;
  GatheredViews set = std::move(settled->second.set);
  gone_ = set.instant;
  ++counters_.sets;
  if (settled->second.here < serials_.size()) ++counters_.incomplete;
  compare_clocks(set, now);
  const auto end = settled.base();  // one after the settled one
  counters_.overtaken += static_cast<std::uint64_t>(std::distance(open_.begin(), end)) - 1;
  open_.erase(open_.begin(), end);
  return set;
}

}  // namespace floatstage::studio
