#include "studio/page/zoom_feed.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

namespace floatstage::studio {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(300);

int begin_of(double at, int length, int piece) {
  return std::clamp(static_cast<int>(std::lround(at * length)) - piece / 2, 0, length - piece);
}

}  // namespace

Image piece_of(const Image& rgb, double x, double y) {
  Image piece(std::min(ZoomFeed::kWidth, rgb.width), std::min(ZoomFeed::kHeight, rgb.height), rgb.channels);
  const int x0 = begin_of(x, rgb.width, piece.width), y0 = begin_of(y, rgb.height, piece.height);
  for (int row = 0; row < piece.height; ++row)
    std::memcpy(piece.at(0, row), rgb.at(x0, y0 + row),
                static_cast<std::size_t>(piece.width) * static_cast<std::size_t>(piece.channels));
  return piece;
}

void ZoomFeed::offer(const Frame& frame) {
  {
    std::lock_guard lock(mutex_);
    if (frame.info.camera != wanted_) return;
    frame_ = frame;
    wanted_ = -1;
  }
  came_.notify_all();
}

Result<Image> ZoomFeed::look(int camera, double x, double y) {
  Frame frame;
  {
    std::unique_lock lock(mutex_);
    wanted_ = camera;
    came_.wait_for(lock, kPatience, [&] { return !frame_.empty(); });
    wanted_ = -1;
    frame = std::exchange(frame_, {});
  }
  if (frame.empty()) return fail(ErrorCode::NotFound, "no picture of this camera comes");
  const Result<Image> whole = to_rgb(frame);
  if (!whole) return forward(whole);
  return piece_of(*whole, x, y);
}

}  // namespace floatstage::studio
