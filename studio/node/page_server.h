#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "studio/messages/studio_control.h"
#include "studio/node/capture_config.h"
#include "studio/node/node_metrics.h"
#include "studio/node/page_viewers.h"
#include "studio/node/preview.h"

struct mg_connection;
struct mg_context;

namespace floatstage::studio {

/// The token that opens a node's page: the first line of the file, or a new random one of 128 bits. NotFound
/// or Io for the file; InvalidArgument for a token of fewer than 16 or other than letters, digits, '-' and
/// '_'.
Result<std::string> page_token(const std::filesystem::path& file);

/// Serves a node's page over HTTP on one port: the page, one WebSocket that carries the status and all
/// previews, commands (/api/…) and /metrics.
///
/// Everything needs the token: as `Authorization: Bearer`, as `?token=` (which a browser exchanges for a
/// cookie of this site), or as that cookie. Without it the answer is 401, and counted.
class PageServer {
 public:
  /// Io where the port is taken. `control` must outlive it.
  static Result<std::unique_ptr<PageServer>> serve(StudioControl& control, std::size_t cameras,
                                                   const CaptureConfig::Web& web, std::string token);
  ~PageServer();

  int port() const { return port_; }
  /// With the token: for the one who started the node.
  std::string url() const;
  PageCounters counters() const;
  /// A tap of the node.
  void offer(const Frame& frame) { previews_->offer(frame); }

 private:
  struct Request;
  PageServer(StudioControl& control, std::string address, std::string token)
      : control_(control), address_(std::move(address)), token_(std::move(token)) {}
  Result<void> start(std::size_t cameras, int port);
  int begin_request(mg_connection* connection);
  int handle(mg_connection* connection);
  int command(mg_connection* connection, const Request& request);
  bool knows_token(const Request& request) const;
  void send_status();

  StudioControl& control_;
  const std::string address_, token_;
  std::string cookie_;
  int port_ = 0;
  mg_context* context_ = nullptr;
  std::unique_ptr<PreviewFeed> previews_;
  std::unique_ptr<PageViewers> viewers_;
  std::atomic<std::uint64_t> requests_{0}, refused_{0};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;  // under mutex_
  std::thread status_thread_;
};

}  // namespace floatstage::studio
