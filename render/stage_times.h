#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace floatstage::render {

/// What the GPU did between one call of enter() and the next, all calls of one stage together.
struct StageTime {
  std::string name;
  double milliseconds = 0;  ///< on the GPU's own clock
  int dispatches = 0;       ///< of compute kernels
  double least_megabytes =
      0;  ///< that those read and write if nothing is read twice and everything is covered
};

/// Adds each stage to that of its name in `sums`, or as a new one after those.
void add(const std::vector<StageTime>& stages, std::vector<StageTime>& sums);

/// Times the stages of what render/gl draws on this thread while it lives, by timer queries; a context must
/// be current. At most one a thread; where there is none, what is timed costs nothing.
class StageTimes {
 public:
  StageTimes();
  ~StageTimes();
  StageTimes(const StageTimes&) = delete;
  StageTimes& operator=(const StageTimes&) = delete;

  /// What comes from now on belongs to `stage` (a literal). Does nothing without a StageTimes.
  static void enter(const char* stage);
  /// One kernel and its bytes.
  static void count(std::size_t bytes);

  /// The stages since the last call in the order in which they were first entered. Waits for the GPU.
  std::vector<StageTime> take();

 private:
  struct Mark {
    const char* stage;
    unsigned query;
    int dispatches;
    std::size_t bytes;
  };
  void mark(const char* stage);
  std::vector<Mark> marks_;
  std::vector<unsigned> free_;
};

}  // namespace floatstage::render
