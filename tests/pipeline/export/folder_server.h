#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

namespace floatstage {

/// The plainest web server: hands out a folder's files on a port of this machine, one request after the
/// other, as long as it lives.
class FolderServer {
 public:
  /// Throws std::runtime_error where no port is to be had.
  explicit FolderServer(std::filesystem::path folder);
  ~FolderServer();
  FolderServer(const FolderServer&) = delete;
  FolderServer& operator=(const FolderServer&) = delete;

  /// "http://127.0.0.1:<port>/"
  std::string url() const;

 private:
  void serve();

  const std::filesystem::path folder_;
  int socket_ = -1, port_ = 0;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

}  // namespace floatstage
