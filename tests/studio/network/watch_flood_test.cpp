// A million subscriptions: a node keeps what one peer may ask for, and the others are served as before.

#include <atomic>
#include <fstream>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zmq.hpp>

#include "core/text.h"
#include "studio/messages/watch_message.h"
#include "studio/network/publisher.h"
#include "studio/network/subscriber.h"
#include "tests/studio/messages/views.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"
#include "tests/support/sanitized.h"

namespace floatstage::studio::wire {
namespace {

using View = std::shared_ptr<const CameraView>;

constexpr int kFlood = 1'000'000;
constexpr double kMostGrownMb = kSanitized ? 2000 : 50;

double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

class WatchFlood : public testing::Test {
 protected:
  void SetUp() override {
    viewer_->want_tiles({"cam1"});
    ASSERT_TRUE(eventually([&] { return node_->wants_tile("cam1"); }));
    ASSERT_TRUE(shows_a_tile());
    before_mb_ = resident_mb();
  }

  // One tile goes through, whole.
  bool shows_a_tile() {
    CameraView view = small_view("cam1");
    view.epoch = shown_;
    node_->publish(std::make_shared<const CameraView>(view));
    const std::optional<Received> received = viewer_->next(milliseconds(20'000));
    if (!received) return false;
    const View tile = std::get<View>(*received);
    EXPECT_EQ(tile->epoch, shown_);
    EXPECT_EQ(tile->tile->picture, view.tile->picture);
    EXPECT_EQ(tile->tile->matte, view.tile->matte);
    ++shown_;
    return tile->epoch + 1 == shown_;
  }

  // Tiles while somebody floods; then what it did.
  void expect_unmoved_by(const std::function<void()>& flood) {
    std::atomic<bool> over{false};
    std::thread stranger([&] {
      flood();
      over = true;
    });
    double most_mb = 0;
    while (!over) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      EXPECT_TRUE(shows_a_tile());
      most_mb = std::max(most_mb, resident_mb());
    }
    stranger.join();
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(shows_a_tile());
    most_mb = std::max(most_mb, resident_mb());
    EXPECT_EQ(viewer_->counters().missed, 0u);
    EXPECT_EQ(viewer_->counters().tiles, shown_);
    EXPECT_EQ(node_->counters().tiles, shown_) << "none for anybody else";
    EXPECT_GT(shown_, 20u) << "while the flood lasted";
    RecordProperty("grown_mb", text(most_mb - before_mb_));
    RecordProperty("tiles", text(shown_));
    EXPECT_LT(most_mb - before_mb_, kMostGrownMb);
  }

  const std::unique_ptr<Publisher> node_ =
      std::move(*Publisher::bind({.address = "tcp://127.0.0.1:0", .keys = {}, .tiles = {TileCode::Raw, 0}}));
  const std::unique_ptr<Subscriber> viewer_ =
      std::move(*Subscriber::connect({{node_->address()}, {}, {}, 8}));
  std::uint64_t shown_ = 0;
  double before_mb_ = 0;
};

TEST_F(WatchFlood, OfAMillionTopicsLeavesMemoryAndTilesOfOthersAsTheyWere) {
  expect_unmoved_by([&] {
    zmq::context_t context;
    zmq::socket_t stranger(context, zmq::socket_type::dealer);
    stranger.set(zmq::sockopt::linger, 0);
    stranger.connect(node_->address());
    // Every thousandth one asks for as much as one may.
    Watch full;
    for (std::size_t i = 1; i < kMostWatched; ++i) full.tiles.insert(text("junk", i));
    for (int i = 0; i < kFlood; ++i) {
      Watch watch = i % 1000 == 0 ? full : Watch();
      watch.tiles.insert(text("topic", i));
      ASSERT_TRUE(stranger.send(zmq::buffer(*encode_watch(watch))));
    }
    ASSERT_TRUE(eventually([&] { return node_->wants_tile(text("topic", kFlood - 1)); }));
    EXPECT_FALSE(node_->wants_tile("topic0")) << "its last word counts";
  });
  EXPECT_EQ(node_->counters().malformed, 0u);
}

TEST_F(WatchFlood, OfJunkIsCountedAndNothingElse) {
  expect_unmoved_by([&] {
    zmq::context_t context;
    zmq::socket_t stranger(context, zmq::socket_type::dealer);
    stranger.set(zmq::sockopt::linger, 0);
    stranger.connect(node_->address());
    for (int i = 0; i < kFlood; ++i) ASSERT_TRUE(stranger.send(zmq::buffer(text("\x01", "topic", i))));
    EXPECT_TRUE(eventually([&] { return node_->counters().malformed == kFlood; }));
  });
}

// A connection that says that it is a subscriber's of ZeroMQ, and subscribes until it is closed; how often.
int subscribe_raw(const std::string& address, int most) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  using namespace std::string_literals;
  // ZMTP 3.0 (RFC 23): signature, version, mechanism, then READY with the type of the socket.
  std::string bytes =
      "\xff"s + std::string(8, '\0') + "\x7f\x03"s + std::string(1, '\0') + "NULL" + std::string(48, '\0');
  const std::string ready = "\x05READY\x0bSocket-Type\0\0\0\x03SUB"s;
  bytes += "\x04"s + static_cast<char>(ready.size()) + ready;
  int sent = 0;
  while (::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) >= 0 && sent < most) {
    bytes.clear();
    for (int i = 0; i < 1000; ++i, ++sent) {
      const std::string topic = text("\x01", "topic", sent);
      bytes += "\0"s + static_cast<char>(topic.size()) + topic;
    }
  }
  ::close(fd);
  return sent;
}

TEST_F(WatchFlood, OfZeroMqsOwnSubscriptionsEndsAtTheDoor) {
  int connections = 0;
  expect_unmoved_by([&] {
    for (int sent = 0; sent < kFlood; ++connections) sent += subscribe_raw(node_->address(), kFlood - sent);
  });
  EXPECT_GT(connections, 1) << "each was closed";
  EXPECT_TRUE(eventually([&] { return node_->counters().refused > 0; }));
  EXPECT_EQ(node_->counters().malformed, 0u) << "none was read";
}

TEST_F(WatchFlood, OfPeersFindsNoSeatAndTakesNobodysAway) {
  zmq::context_t context;
  std::vector<zmq::socket_t> strangers;
  for (int i = 0; i < 100; ++i) {
    zmq::socket_t& stranger = strangers.emplace_back(context, zmq::socket_type::dealer);
    stranger.set(zmq::sockopt::linger, 0);
    stranger.connect(node_->address());
    Watch watch{{}, {text("of", i)}};
    for (std::size_t k = 1; k < kMostWatched; ++k) watch.tiles.insert(text("junk", i, "of", k));
    ASSERT_TRUE(stranger.send(zmq::buffer(*encode_watch(watch))));
  }
  EXPECT_TRUE(eventually([&] { return node_->counters().turned_away >= 30; }));
  EXPECT_TRUE(shows_a_tile());
  EXPECT_LT(resident_mb() - before_mb_, kMostGrownMb);
}

}  // namespace
}  // namespace floatstage::studio::wire
