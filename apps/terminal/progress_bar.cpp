#include "apps/terminal/progress_bar.h"

#include <cstdio>

#include <unistd.h>

#include "apps/terminal/interrupt.h"

namespace floatstage::apps {
namespace {

constexpr double kQuietSeconds = 2, kRedrawSeconds = 0.1;
constexpr int kBarWidth = 30;

}  // namespace

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) != 0) {}

void ProgressBar::begin(const std::string& what, std::size_t total) {
  std::lock_guard lock(mutex_);
  what_ = what;
  total_ = total;
  done_ = 0;
  last_drawn_ = 0;
  begin_ = std::chrono::steady_clock::now();
}

void ProgressBar::advance(std::size_t items) {
  std::lock_guard lock(mutex_);
  done_ += items;
  if (!terminal_) return;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (elapsed < kQuietSeconds || (elapsed - last_drawn_ < kRedrawSeconds && done_ < total_)) return;
  draw(elapsed);
}

void ProgressBar::end() {
  std::lock_guard lock(mutex_);
  if (visible_) std::fputs("\r\033[K", stderr);
  visible_ = false;
}

bool ProgressBar::cancelled() const { return interrupted(); }

void ProgressBar::draw(double elapsed) {
  last_drawn_ = elapsed;
  visible_ = true;
  const int filled = total_ ? static_cast<int>(done_ * kBarWidth / total_) : 0;
  const double left = done_ ? elapsed / static_cast<double>(done_) * static_cast<double>(total_ - done_) : 0;
  std::fprintf(stderr, "\r\033[K%s [%.*s%*s] %zu/%zu, %.0f s left", what_.c_str(), filled,
               "##############################", kBarWidth - filled, "", done_, total_, left);
  std::fflush(stderr);
}

}  // namespace floatstage::apps
