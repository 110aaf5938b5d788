#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/frame.h"
#include "core/result.h"

namespace floatstage::studio {

/// The frame's picture, shrunk by a whole number so that it is at most `most_width` wide (each pixel the mean
/// of those it stands for), as RGB. Errors: those of to_rgb().
Result<Image> preview_picture(const Frame& frame, int most_width);

/// Small JPEGs of what the cameras see, for people: the newest picture of each camera, some times a second,
/// made on a thread of its own. Nothing waits for it: pictures that come while it is busy are passed over,
/// and it holds at most one of a camera's buffers.
class PreviewFeed {
 public:
  /// `sink` is called on the feed's thread.
  using Sink = std::function<void(int camera, std::shared_ptr<const std::string> jpeg)>;
  PreviewFeed(std::size_t cameras, double per_second, Sink sink);
  ~PreviewFeed();

  /// From the cameras' threads: a tap of the node.
  void offer(const Frame& frame);
  /// Nothing is made while nobody looks.
  void set_wanted(bool wanted) { wanted_ = wanted; }

 private:
  struct Slot {
    std::mutex mutex;
    bool asked = false;
    Frame frame;
  };
  void run();
  void make(std::size_t camera);

  const double per_second_;
  const Sink sink_;
  std::vector<std::unique_ptr<Slot>> slots_;
  std::atomic<bool> wanted_{false};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;  // under mutex_
  std::thread thread_;
};

}  // namespace floatstage::studio
