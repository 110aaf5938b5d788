#pragma once

#include <condition_variable>
#include <mutex>

#include "core/frame.h"
#include "core/result.h"

namespace floatstage::studio {

/// A piece of what a camera sees, pixel by pixel, for people who focus it. Holds no frame while nobody looks.
class ZoomFeed {
 public:
  static constexpr int kWidth = 320, kHeight = 240;  ///< px of the piece, where the picture has so many

  /// From the cameras' threads: a tap of the node. Never waits for long.
  void offer(const Frame& frame);
  /// RGB around (x, y), 0…1 of the picture's width and height, of the camera's next picture. NotFound when
  /// none comes within 0.3 s; errors of to_rgb(). One thread at a time.
  Result<Image> look(int camera, double x, double y);

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  int wanted_ = -1;
  Frame frame_;
};

/// The piece of a picture: kWidth x kHeight px or all there is, around (x, y), inside of it.
Image piece_of(const Image& rgb, double x, double y);

}  // namespace floatstage::studio
