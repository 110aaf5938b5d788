#pragma once

#include <atomic>
#include <filesystem>
#include <future>

#include "pipeline/film.h"

namespace floatstage {

/// "Render this path", beside the player: a thread with its own take reader and GL context.
class FilmJob {
 public:
  FilmJob(std::filesystem::path take, CameraPath path, FilmOptions options, std::filesystem::path out);
  ~FilmJob();  ///< gives up what is not done

  bool done() const;
  int pictures() const { return pictures_; }
  Result<FilmReport> result();  ///< once, when done()

 private:
  Result<FilmReport> run(const std::filesystem::path& take, const CameraPath& path,
                         const FilmOptions& options, const std::filesystem::path& out);

  std::atomic<int> pictures_ = 0;
  std::atomic<bool> give_up_ = false;
  std::future<Result<FilmReport>> future_;
};

}  // namespace floatstage
