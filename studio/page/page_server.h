#pragma once

#include <memory>
#include <string>

#include "core/frame.h"
#include "studio/messages/studio_control.h"
#include "studio/page/node_metrics.h"
#include "studio/page/page_settings.h"

namespace floatstage::studio {

/// Serves a node's page over HTTP on one port: the page, one WebSocket that carries the status and all
/// previews, orders (/api/…) and /metrics. Who may use it: PageAccess; all others get 401 or 403, and are
/// counted.
///
/// One thread reads and writes all sockets and waits for nobody; orders run one after the other on a thread
/// of their own, questions on another. An order whose client has gone before its turn is not carried out.
class PageServer {
 public:
  /// Io where the port is taken, InvalidArgument for what is no address. `control` must outlive it.
  static Result<std::unique_ptr<PageServer>> serve(StudioControl& control, std::size_t cameras,
                                                   const PageSettings& settings, std::string token);
  ~PageServer();

  int port() const;
  /// With the token: for the one who started the node.
  std::string url() const;
  PageCounters counters() const;
  /// A tap of the node.
  void offer(const Frame& frame);

 private:
  struct Impl;
  explicit PageServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::studio
