#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/result.h"
#include "matting/video/video_matting.h"

// Private to the stage: the first phase of video matting.
namespace floatstage::matting {

/// A clip's matting components on disk, made in runs of kRun frames: each run starts cold and goes on warm,
/// its components follow one another, and runs are independent, so that they are made in parallel with the
/// same result at any thread count. What is there already, for these photographs and options, is not made
/// again.
class ComponentStore {
 public:
  static constexpr int kRun = 12;

  ComponentStore(std::filesystem::path folder, int width, int height, const SpectralOptions& options)
      : folder_(std::move(folder)), width_(width), height_(height), options_(options) {}

  /// `small` gives a frame in working size. Returns how many frames from the first are there, and the error
  /// of the first that is not.
  struct Outcome {
    int usable = 0;
    Result<void> result;
  };
  Outcome prepare(int frames, int threads, const std::function<Result<Image>(int)>& small,
                  const std::function<bool(int)>& done) const;

  Result<MattingComponents> load(int frame) const;

 private:
  Result<void> prepare_run(int first, int last, const std::function<Result<Image>(int)>& small,
                           const std::function<bool(int)>& done, int& made) const;
  std::filesystem::path file(int frame, const char* extension) const;

  std::filesystem::path folder_;
  int width_, height_;
  SpectralOptions options_;
};

}  // namespace floatstage::matting
