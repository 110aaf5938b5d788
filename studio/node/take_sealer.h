#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>

namespace floatstage::studio {

/// Seals finished takes one after the other on a thread of its own, and only while `quiet` holds: reading a
/// long take back must not cost a recording its disk. Thread safe.
class TakeSealer {
 public:
  explicit TakeSealer(std::function<bool()> quiet);
  /// Gives up what is not sealed yet; it is complete all the same, and `take seal` does it later.
  ~TakeSealer();

  void add(std::filesystem::path take);
  /// Until everything is sealed; false once `stop` has answered yes.
  bool wait(const std::function<bool()>& stop);

 private:
  void run();
  bool go_on();  // waits for quiet; false when everything is over

  const std::function<bool()> quiet_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<std::filesystem::path> waiting_;  // the first one is being sealed
  bool over_ = false;
  std::thread thread_;
};

}  // namespace floatstage::studio
