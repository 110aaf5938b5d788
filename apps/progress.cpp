#include "apps/progress.h"

#include <cstdio>

#include <unistd.h>

namespace floatstage {
namespace {

constexpr double kQuietSeconds = 2, kRedrawSeconds = 0.1;
constexpr int kBarWidth = 30;

}  // namespace

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) != 0),
      begin_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (visible_) std::fputs("\r\033[K", stderr);
}

void Progress::advance(std::size_t items) {
  std::lock_guard lock(mutex_);
  done_ += items;
  if (!terminal_) return;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (elapsed < kQuietSeconds || (elapsed - last_drawn_ < kRedrawSeconds && done_ < total_)) return;
  draw(elapsed);
}

void Progress::draw(double elapsed) {
  last_drawn_ = elapsed;
  visible_ = true;
  const int filled = total_ ? static_cast<int>(done_ * kBarWidth / total_) : 0;
  const double left = done_ ? elapsed / static_cast<double>(done_) * static_cast<double>(total_ - done_) : 0;
  std::fprintf(stderr, "\r\033[K%s [%.*s%*s] %zu/%zu, %.0f s left", what_.c_str(), filled,
               "##############################", kBarWidth - filled, "", done_, total_, left);
  std::fflush(stderr);
}

}  // namespace floatstage
