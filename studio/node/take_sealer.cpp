#include "studio/node/take_sealer.h"

#include <chrono>
#include <utility>

#include "capture/take_check.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::studio {
namespace {

constexpr std::chrono::milliseconds kTurn{100};

}  // namespace

TakeSealer::TakeSealer(std::function<bool()> quiet) : quiet_(std::move(quiet)), thread_([this] { run(); }) {}

TakeSealer::~TakeSealer() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void TakeSealer::add(std::filesystem::path take) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(take));
  }
  changed_.notify_all();
}

bool TakeSealer::wait(const std::function<bool()>& stop) {
  std::unique_lock lock(mutex_);
  while (!waiting_.empty()) {
    if (stop()) return false;
    changed_.wait_for(lock, kTurn);
  }
  return true;
}

bool TakeSealer::go_on() {
  std::unique_lock lock(mutex_);
  while (!over_) {
    lock.unlock();
    const bool quiet = quiet_();
    lock.lock();
    if (quiet) break;
    changed_.wait_for(lock, kTurn);
  }
  return !over_;
}

void TakeSealer::run() {
  for (;;) {
    std::filesystem::path take;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return over_ || !waiting_.empty(); });
      if (over_) return;
      take = waiting_.front();
    }
    const Result<void> sealed = capture::seal_take(take, [this](std::uint64_t) { return go_on(); });
    if (!sealed && sealed.error().code == ErrorCode::Cancelled)
      log::info(text(take.string(), " is complete but not sealed; `floatstage take seal` does it"));
    else if (!sealed)
      log::warning(sealed.error().message);
    {
      const std::lock_guard lock(mutex_);
      waiting_.pop_front();
    }
    changed_.notify_all();
  }
}

}  // namespace floatstage::studio
