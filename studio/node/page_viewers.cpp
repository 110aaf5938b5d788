#include "studio/node/page_viewers.h"

#include <algorithm>

#include <civetweb.h>

namespace floatstage::studio {

void PageViewers::run(Viewer& viewer) {
  while (const std::optional<Message> message = viewer.messages.pop()) {
    const int kind =
        message->kind == Message::Kind::Text ? MG_WEBSOCKET_OPCODE_TEXT : MG_WEBSOCKET_OPCODE_BINARY;
    // A connection that is gone is removed by its own handler; until then nothing more is tried.
    if (mg_websocket_write(viewer.connection, kind, message->bytes->data(), message->bytes->size()) <= 0)
      viewer.messages.close();
  }
}

void PageViewers::end(Viewer& viewer) {
  viewer.messages.close();
  if (viewer.sender.joinable()) viewer.sender.join();
}

void PageViewers::add(mg_connection* connection) {
  auto viewer = std::make_unique<Viewer>(connection, queue_);
  viewer->sender = std::thread([v = viewer.get()] { run(*v); });
  std::lock_guard lock(mutex_);
  viewers_.push_back(std::move(viewer));
}

void PageViewers::remove(mg_connection* connection) {
  std::unique_ptr<Viewer> gone;
  {
    std::lock_guard lock(mutex_);
    const auto found = std::find_if(viewers_.begin(), viewers_.end(),
                                    [&](const auto& viewer) { return viewer->connection == connection; });
    if (found == viewers_.end()) return;
    gone = std::move(*found);
    viewers_.erase(found);
    dropped_ += gone->messages.counters().dropped;
  }
  end(*gone);
}

void PageViewers::send(const Message& message) {
  std::lock_guard lock(mutex_);
  for (const auto& viewer : viewers_) viewer->messages.push(message);
}

void PageViewers::close() {
  std::list<std::unique_ptr<Viewer>> all;
  {
    std::lock_guard lock(mutex_);
    all.swap(viewers_);
  }
  for (const auto& viewer : all) end(*viewer);
}

std::size_t PageViewers::count() const {
  std::lock_guard lock(mutex_);
  return viewers_.size();
}

std::uint64_t PageViewers::dropped() const {
  std::lock_guard lock(mutex_);
  std::uint64_t sum = dropped_;
  for (const auto& viewer : viewers_) sum += viewer->messages.counters().dropped;
  return sum;
}

}  // namespace floatstage::studio
