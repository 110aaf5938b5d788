// What unknown_cameras, other releases and programs that hang do to a studio: nothing.

#include <gtest/gtest.h>
#include <zmq.hpp>

#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/messages/watch_message.h"
#include "studio/network/control_client.h"
#include "studio/network/control_server.h"
#include "studio/network/publisher.h"
#include "studio/network/subscriber.h"
#include "tests/fuzz/mutations.h"
#include "tests/studio/messages/views.h"
#include "tests/studio/network/scripted_control.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

using View = std::shared_ptr<const CameraView>;

constexpr int kMalformed = 10'000;

// A node that sends what it likes.
struct FalseNode {
  zmq::context_t context;
  zmq::socket_t socket{context, zmq::socket_type::router};
  std::string address, peer;

  FalseNode() {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::router_mandatory, true);  // each one arrives
    socket.bind("tcp://127.0.0.1:*");
    address = socket.get(zmq::sockopt::last_endpoint);
  }
  void wait_for_a_watch() {
    zmq::message_t id, watch;
    ASSERT_TRUE(socket.recv(id) && socket.recv(watch));
    peer = id.to_string();
    const Result<Message> message = open(watch.to_string_view());
    ASSERT_THAT(message, IsOk());
    EXPECT_EQ(decode_watch(*message)->kinds.size(), 4u);
  }
  void send(const std::string& bytes) {
    ASSERT_TRUE(socket.send(zmq::buffer(peer), zmq::send_flags::sndmore));
    ASSERT_TRUE(socket.send(zmq::buffer(bytes)));
  }
};

std::unique_ptr<Subscriber> listener(const std::string& address) {
  Result<std::unique_ptr<Subscriber>> connected = Subscriber::connect(
      {{address}, {}, {MessageKind::Outline, MessageKind::Tile, MessageKind::Scene, MessageKind::Status}, 8});
  EXPECT_THAT(connected, IsOk());
  return std::move(*connected);
}

std::vector<std::string> one_of_each() {
  StudioScene scene;
  scene.rig_sha256 = std::string(64, 'b');
  scene.cameras = {{"cam0", {1}}};
  scene.mesh.positions.resize(3, Eigen::Vector3f::Zero());
  scene.mesh.triangles = {0, 1, 2};
  const CameraView view = small_view("cam1");
  return {*encode_outline(view), *encode_tile(view, {TileCode::Raw, 0}), *encode_tile(view, {}),
          *encode_scene(scene), *encode_status(ScriptedControl().status())};
}

TEST(HostilePeers, TenThousandMalformedMessagesAreCountedAndTheNextGoodOneIsRead) {
  FalseNode node;
  const auto recon = listener(node.address);
  node.wait_for_a_watch();
  const std::vector<std::string> seeds = one_of_each();
  std::uint64_t sent = 0;
  for (std::size_t i = 0; sent < kMalformed; ++i) {
    const std::string& seed = seeds[i % seeds.size()];
    const std::string bytes = mutated(seed, i / seeds.size() % mutation_count(seed.size()));
    const Result<Message> message = open(bytes);
    if (message) continue;  // a header that survived: the next test
    node.send(bytes);
    ++sent;
  }
  CameraView good = small_view("cam1", 4711);
  node.send(*encode_outline(good));
  ASSERT_TRUE(eventually([&] { return recon->counters().outlines == 1; }));
  const SubscriberCounters counts = recon->counters();
  EXPECT_EQ(counts.malformed + counts.other_version, static_cast<std::uint64_t>(kMalformed));
  EXPECT_GT(counts.other_version, 0u);
  const std::optional<Received> received = recon->next(milliseconds(5000));
  ASSERT_TRUE(received);
  EXPECT_EQ(std::get<View>(*received)->epoch, 4711u);
}

TEST(HostilePeers, SpoiltPayloadsBehindGoodHeadersAreCountedToo) {
  FalseNode node;
  const auto recon = listener(node.address);
  node.wait_for_a_watch();
  std::uint64_t sent = 0;
  for (const std::string& seed : one_of_each()) {
    MessageHeader header = open(seed)->header;
    for (std::size_t i = 0; i < 600; ++i, ++sent)
      node.send(*seal(header, mutated(seed.substr(kHeaderBytes), i)));
  }
  ASSERT_TRUE(eventually([&] { return recon->counters().messages == sent; }));
  const SubscriberCounters counts = recon->counters();
  EXPECT_EQ(counts.malformed + counts.outlines + counts.tiles + counts.scenes + counts.statuses, sent);
  EXPECT_GT(counts.malformed, sent / 2);
}

TEST(HostilePeers, AMessageOfAnotherReleaseIsCountedAsThat) {
  FalseNode node;
  const auto recon = listener(node.address);
  node.wait_for_a_watch();
  std::string newer = *encode_outline(small_view("cam1"));
  newer[48] = static_cast<char>(kWireVersion + 1);
  node.send(newer);
  EXPECT_TRUE(eventually([&] { return recon->counters().other_version == 1; }));
  EXPECT_EQ(recon->counters().malformed, 0u);
}

TEST(HostilePeers, AMessageThatIsMissingShowsInTheNumbers) {
  FalseNode node;
  const auto recon = listener(node.address);
  node.wait_for_a_watch();
  for (std::uint64_t sequence : {5u, 6u, 9u}) {
    std::string bytes = *encode_outline(small_view("cam1", sequence));
    stamp(bytes, 1, sequence);
    node.send(bytes);
  }
  ASSERT_TRUE(eventually([&] { return recon->counters().outlines == 3; }));
  EXPECT_EQ(recon->counters().missed, 2u);
}

TEST(HostilePeers, ASubscriberThatNeverReadsMissesMessagesAndNobodyElseDoes) {
  PublisherOptions options{.address = "tcp://127.0.0.1:0", .keys = {}, .tiles = {TileCode::Raw, 0}};
  options.per_peer = 8;
  const auto node = std::move(*Publisher::bind(options));
  zmq::context_t context;
  zmq::socket_t stuck(context, zmq::socket_type::dealer);
  stuck.set(zmq::sockopt::linger, 0);
  stuck.set(zmq::sockopt::rcvhwm, 1);
  stuck.connect(node->address());
  stuck.send(zmq::buffer(*encode_watch({{}, {"big"}})));
  ASSERT_TRUE(eventually([&] { return node->wants_tile("big"); }));
  const auto reader = std::move(*Subscriber::connect({{node->address()}, {}, {MessageKind::Outline}, 8}));
  reader->want_tiles({"big", "last"});
  ASSERT_TRUE(eventually([&] { return node->wants_tile("last"); })) << "and so all before it";

  auto view = std::make_shared<CameraView>(small_view("big"));
  view->width = view->height = 1024;
  auto tile = std::make_shared<ForegroundTile>();
  tile->picture = Image(1024, 1024, 3, 77);
  tile->matte = Image(1024, 1024, 1, 255);
  view->tile = tile;
  // Two hundred megabytes and more: no socket buffer holds them.
  constexpr std::uint64_t kRounds = 80;
  for (std::uint64_t round = 0; round < kRounds; ++round) {
    view->epoch = round;
    node->publish(std::make_shared<const CameraView>(*view));
    std::optional<Received> received;
    do {
      ASSERT_TRUE(received = reader->next(milliseconds(20'000)));
    } while (!std::get<View>(*received)->tile);
  }
  EXPECT_EQ(reader->counters().missed, 0u);
  EXPECT_EQ(node->counters().dropped, 0u);
  EXPECT_GT(node->counters().left_out, 0u);
  stuck.set(zmq::sockopt::rcvtimeo, 500);
  std::uint64_t got = 0;
  for (zmq::message_t message; stuck.recv(message);) ++got;
  EXPECT_LT(got, kRounds / 2) << "the rest was never stored for it";
  EXPECT_GT(got, 0u);
}

TEST(HostilePeers, TenThousandWatchesThatAreNoneLeaveANodeAsItWas) {
  const auto node = std::move(*Publisher::bind({.address = "tcp://127.0.0.1:0"}));
  zmq::context_t context;
  zmq::socket_t stranger(context, zmq::socket_type::dealer);
  stranger.set(zmq::sockopt::linger, 0);
  stranger.set(zmq::sockopt::sndhwm, 0);
  stranger.connect(node->address());
  const std::string seed = *encode_watch({{MessageKind::Outline}, {"cam1", "cam2", "cam3"}});
  std::uint64_t sent = 0;
  for (std::size_t i = 0; sent < kMalformed; ++i) {
    const std::string bytes = mutated(seed, i % mutation_count(seed.size()));
    const Result<Message> message = open(bytes);
    if (message && decode_watch(*message)) continue;  // harmless after all
    stranger.send(zmq::buffer(bytes), i % 10 == 0 ? zmq::send_flags::sndmore : zmq::send_flags::none);
    if (i % 10 == 0) stranger.send(zmq::buffer(bytes));
    ++sent;
  }
  EXPECT_TRUE(eventually([&] {
    const PublisherCounters counts = node->counters();
    return counts.malformed + counts.other_version == kMalformed;
  })) << node->counters().malformed;
  const auto viewer = std::move(*Subscriber::connect({{node->address()}, {}, {}, 8}));
  viewer->want_tiles({"cam1"});
  EXPECT_TRUE(eventually([&] { return node->wants_tile("cam1"); }));
}

TEST(HostilePeers, TenThousandRequestsThatAreNoneLeaveTheControlAnswering) {
  ScriptedControl control;
  const auto server = std::move(*ControlServer::bind("tcp://127.0.0.1:0", {}, control));
  zmq::context_t context;
  zmq::socket_t stranger(context, zmq::socket_type::dealer);
  stranger.set(zmq::sockopt::linger, 0);
  stranger.set(zmq::sockopt::sndhwm, 0);
  stranger.connect(server->address());
  const std::string seed = *encode_request({Ask::StartRecording, "duet"});
  std::uint64_t sent = 0;
  for (std::size_t i = 0; sent < kMalformed; ++i) {
    const std::string bytes = mutated(seed, i % mutation_count(seed.size()));
    const Result<Message> message = open(bytes);
    if (message && decode_request(*message)) continue;  // harmless after all
    stranger.send(zmq::buffer(bytes));
    ++sent;
  }
  ASSERT_TRUE(eventually([&] {
    const ControlCounters counts = server->counters();
    return counts.malformed + counts.other_version == kMalformed;
  }));
  EXPECT_EQ(server->counters().requests, 0u);
  const auto client = std::move(*ControlClient::connect(server->address(), {}, milliseconds(20'000)));
  EXPECT_THAT(client->start_recording("duet"), IsOk());
}

TEST(HostilePeers, WhoSpeaksNoZeroMqIsShownTheDoor) {
  const auto node = std::move(*Publisher::bind({.address = "tcp://127.0.0.1:0"}));
  zmq::context_t context;
  zmq::socket_t raw(context, zmq::socket_type::stream);
  raw.set(zmq::sockopt::linger, 0);
  raw.connect(node->address());
  zmq::message_t id;
  ASSERT_TRUE(raw.recv(id));  // connected
  const std::string peer(static_cast<const char*>(id.data()), id.size());
  zmq::message_t ignored;
  ASSERT_TRUE(raw.recv(ignored));
  raw.send(zmq::buffer(peer), zmq::send_flags::sndmore);
  raw.send(zmq::buffer(std::string(100'000, 'G')));
  const auto recon = std::move(*Subscriber::connect({{node->address()}, {}, {MessageKind::Outline}, 8}));
  EXPECT_TRUE(eventually([&] {
    node->publish(std::make_shared<const CameraView>(small_view("cam1")));
    return recon->next(milliseconds(20)).has_value();
  }));
}

}  // namespace
}  // namespace floatstage::studio::wire
