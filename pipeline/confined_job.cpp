#include "pipeline/confined_job.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace floatstage::pipeline {
namespace {

// What the child tells: "b<items> <what>", "a<items>", "e".
class Told final : public Progress {
 public:
  explicit Told(const Tell& tell) : tell_(tell) {}
  void begin(const std::string& what, std::size_t total) override { tell_(text('b', total, ' ', what)); }
  void advance(std::size_t items) override { tell_(text('a', items)); }
  void end() override { tell_("e"); }
  bool cancelled() const override { return asked_to_end(); }

 private:
  const Tell& tell_;
};

/// Hands on what was told, in order: an end for every begin, whatever a stranger says.
class Shown {
 public:
  explicit Shown(Progress& progress) : progress_(progress) {}
  ~Shown() { end(); }
  Shown(const Shown&) = delete;
  Shown& operator=(const Shown&) = delete;

  void hear(std::string_view told) {
    if (told.empty()) return;
    std::size_t items = 0;
    const auto [rest, error] = std::from_chars(told.data() + 1, told.data() + told.size(), items);
    if (told[0] == 'e') return end();
    if (error != std::errc()) return;
    if (told[0] == 'a' && begun_) progress_.advance(items);
    if (told[0] != 'b') return;
    end();
    const std::size_t at = static_cast<std::size_t>(rest - told.data());
    progress_.begin(std::string(told.substr(std::min(at + 1, told.size()))), items);
    begun_ = true;
  }

 private:
  void end() {
    if (begun_) progress_.end();
    begun_ = false;
  }
  Progress& progress_;
  bool begun_ = false;
};

}  // namespace

Result<std::string> run_confined_bytes(const Confinement& limits, Progress* progress,
                                       const std::function<Result<std::string>(Progress*)>& job) {
  std::optional<Shown> shown;
  if (progress) shown.emplace(*progress);
  return run_confined(
      limits,
      [&](const Tell& tell) {
        Told told(tell);
        return job(progress ? &told : nullptr);
      },
      [&](std::string_view told) -> Result<void> {
        if (is_cancelled(progress)) return cancelled_unwritten();
        if (shown) shown->hear(told);
        return {};
      });
}

}  // namespace floatstage::pipeline
