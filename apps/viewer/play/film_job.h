#pragma once

#include <atomic>
#include <filesystem>
#include <future>

#include "pipeline/chosen_take.h"
#include "pipeline/film.h"

namespace floatstage::apps {

/// "Render this path", beside the player: a thread with its own take reader and, with GL, its own context.
class FilmJob {
 public:
  FilmJob(std::filesystem::path take, pipeline::LabelChoice labels, pipeline::CameraPath path,
          pipeline::FilmOptions options, std::filesystem::path out);
  ~FilmJob();  ///< gives up what is not done

  bool done() const;
  int pictures() const { return pictures_; }
  Result<pipeline::FilmReport> result();  ///< once, when done()

 private:
  Result<pipeline::FilmReport> run(const std::filesystem::path& take, const pipeline::LabelChoice& labels,
                                   const pipeline::CameraPath& path, const pipeline::FilmOptions& options,
                                   const std::filesystem::path& out);

  std::atomic<int> pictures_ = 0;
  std::atomic<bool> give_up_ = false;
  std::future<Result<pipeline::FilmReport>> future_;
};

}  // namespace floatstage::apps
