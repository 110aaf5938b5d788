// What programs that speak nonsense, have other keys or hang do to a studio of several machines: nothing.

#include <zmq.hpp>

#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/messages/view_message.h"
#include "studio/messages/watch_message.h"
#include "studio/network/link.h"
#include "studio/network/subscriber.h"
#include "tests/fuzz/mutations.h"
#include "tests/studio/machines/studio_faults.h"
#include "tests/studio/messages/views.h"

namespace floatstage::studio {
namespace {

using wire::MessageKind;

constexpr int kMalformed = 10'000;

// A socket of a machine of the studio that has gone mad: it has the keys.
struct Mad {
  zmq::context_t context;
  zmq::socket_t socket;
  Mad(zmq::socket_type type, const std::string& address, const wire::StudioKeys& keys)
      : socket(context, type) {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::sndhwm, 0);
    wire::become_client(socket, keys);
    socket.connect(address);
  }
};

// Version `i` of a message that is damaged; empty where it makes sense.
std::string malformed(const std::string& seed, int i) {
  std::string bytes = mutated(seed, static_cast<std::size_t>(i) % mutation_count(seed.size()));
  return wire::open(bytes) ? std::string() : bytes;
}

// Watches that are none, then one that is: when it is served, all before it were read.
void watch_nonsense(const std::string& address, const wire::StudioKeys& keys, MessageKind good) {
  Mad stranger(zmq::socket_type::dealer, address, keys);
  const std::string seed = *wire::encode_watch({{good}, {"cam1"}});
  for (int i = 0, sent = 0; sent < kMalformed; ++i) {
    const std::string bytes = malformed(seed, i);
    if (bytes.empty()) continue;
    stranger.socket.send(zmq::buffer(bytes));
    ++sent;
  }
  stranger.socket.send(zmq::buffer(seed));
  zmq::message_t served;
  EXPECT_TRUE(stranger.socket.recv(served));
}

// Requests that are none, and now and then one that is, until that is answered.
void ask_nonsense(const std::string& address, const wire::StudioKeys& keys) {
  Mad stranger(zmq::socket_type::dealer, address, keys);
  const std::string good = *wire::encode_request({wire::Ask::Status, ""});
  const std::string seed = *wire::encode_request({wire::Ask::StartRecording, "duet"});
  bool answered = false;
  const auto read = [&] {
    for (zmq::message_t reply; stranger.socket.recv(reply, zmq::recv_flags::dontwait);) {
      const Result<wire::Message> message = wire::open(wire::bytes_of(reply));
      if (message && wire::decode_reply(*message)) answered = true;
    }
  };
  for (int i = 0, sent = 0; sent < kMalformed; ++i) {
    const std::string bytes = malformed(seed, i);
    if (bytes.empty()) continue;
    stranger.socket.send(zmq::buffer(bytes));
    ++sent;
    read();
  }
  EXPECT_FALSE(answered);
  EXPECT_TRUE(eventually(
      [&] {
        stranger.socket.send(zmq::buffer(good));
        zmq::pollitem_t item{stranger.socket.handle(), 0, ZMQ_POLLIN, 0};
        wire::wait_for(std::span(&item, 1), std::chrono::milliseconds(500));
        read();
        return answered;
      },
      std::chrono::seconds(120)));
}

TEST_F(StudioFaults, TenThousandMalformedMessagesOfEachKindAreCountedAndHarmNothing) {
  const std::filesystem::path take = record(kLeft);
  ask_nonsense(studio_.control_address(kLeft), studio_.keys);
  watch_nonsense(studio_.node_address(kLeft), studio_.keys, MessageKind::Outline);
  watch_nonsense(studio_.recon_address(), studio_.keys, MessageKind::Scene);

  // In the right node's place: outlines for the reconstruction, scenes for the view.
  right_->terminate();
  EXPECT_EQ(right_->wait(), 0);
  ASSERT_TRUE(studio_.lab->enter(kRight));
  {
    zmq::context_t context;
    zmq::socket_t socket(context, zmq::socket_type::router);
    socket.set(zmq::sockopt::linger, -1);
    socket.set(zmq::sockopt::router_mandatory, true);  // each one arrives
    socket.set(zmq::sockopt::curve_server, true);
    socket.set(zmq::sockopt::curve_publickey, studio_.keys.public_key);
    socket.set(zmq::sockopt::curve_secretkey, studio_.keys.secret_key);
    socket.bind(studio_.node_address(kRight));
    ASSERT_TRUE(studio_.lab->enter(kView));
    std::map<MessageKind, std::string> watchers;
    while (!watchers.contains(MessageKind::Outline) || !watchers.contains(MessageKind::Scene)) {
      zmq::message_t id, bytes;
      ASSERT_TRUE(socket.recv(id) && socket.recv(bytes));
      const Result<wire::Message> message = wire::open(wire::bytes_of(bytes));
      ASSERT_THAT(message, IsOk());
      const Result<wire::Watch> watch = wire::decode_watch(*message);
      ASSERT_THAT(watch, IsOk());
      for (MessageKind kind : watch->kinds) watchers[kind] = id.to_string();
    }
    StudioScene scene;
    scene.rig_sha256 = std::string(64, 'b');
    scene.mesh.positions.resize(3, Eigen::Vector3f::Zero());
    scene.mesh.triangles = {0, 1, 2};
    for (const auto& [kind, seed] :
         {std::pair(MessageKind::Outline, *wire::encode_outline(small_view("cam01"))),
          std::pair(MessageKind::Scene, *wire::encode_scene(scene))})
      for (int i = 0, sent = 0; sent < kMalformed; ++i) {
        const std::string bytes = malformed(seed, i);
        if (bytes.empty()) continue;
        ASSERT_TRUE(socket.send(zmq::buffer(watchers[kind]), zmq::send_flags::sndmore));
        ASSERT_TRUE(socket.send(zmq::buffer(bytes)));
        ++sent;
      }
    // What ZeroMQ holds is lost when somebody's link goes: end only when the view has all of it.
    EXPECT_TRUE(eventually(
        [&] {
          scenes_->newest(now() + milliseconds(20));
          const wire::SubscriberCounters counts = scenes_->network().network;
          return counts.malformed + counts.other_version == kMalformed;
        },
        kPatience));
  }

  right_ = studio_.start_node(kRight);
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_THAT(control(kLeft).stop_recording(), IsOk());
  expect_no_silent_loss(take, true);
  const nlohmann::json made = end(*recon_, "recon"), told = end(*left_, "node0");
  EXPECT_EQ(made["from_nodes"]["malformed"].get<int>() + made["from_nodes"]["other_version"].get<int>(),
            kMalformed);
  EXPECT_EQ(made["to_viewers"]["malformed"], kMalformed);
  EXPECT_EQ(told["published"]["malformed"], 2 * kMalformed) << "watches and requests";
}

TEST_F(StudioFaults, WhoHasOtherKeysIsRefusedAndCounted) {
  const wire::StudioKeys others = *wire::make_keys();
  const Result<std::unique_ptr<wire::Subscriber>> spy = wire::Subscriber::connect(
      {{studio_.node_address(kLeft), studio_.recon_address()},
       others,
       {MessageKind::Outline, MessageKind::Tile, MessageKind::Scene, MessageKind::Status},
       8});
  ASSERT_THAT(spy, IsOk());
  EXPECT_TRUE(eventually([&] { return (*spy)->counters().refused >= 4; }, kPatience)) << "again and again";
  const Result<std::unique_ptr<wire::ControlClient>> thief =
      wire::ControlClient::connect(studio_.control_address(kLeft), others, milliseconds(2000));
  ASSERT_THAT(thief, IsOk());
  EXPECT_THAT((*thief)->start_recording("mine"), FailsWith(ErrorCode::Timeout, "are its keys the same"));
  EXPECT_EQ((*spy)->counters().messages, 0u);
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_FALSE(control(kLeft).status().recording);
  EXPECT_GT(end(*left_, "node0")["published"]["refused"], 0);
  EXPECT_GT(end(*recon_, "recon")["to_viewers"]["refused"], 0);
}

TEST_F(StudioFaults, ASubscriberThatNeverReadsMissesMessagesAndNobodyElseDoes) {
  const std::filesystem::path take = record(kLeft);
  studio_.lab->shrink_send_buffers(kLeft);
  zmq::context_t context;
  zmq::socket_t stuck(context, zmq::socket_type::dealer);
  stuck.set(zmq::sockopt::linger, 0);
  stuck.set(zmq::sockopt::rcvhwm, 1);
  stuck.set(zmq::sockopt::rcvbuf, 4096);
  wire::become_client(stuck, studio_.keys);
  stuck.connect(studio_.node_address(kLeft));
  const std::set<std::string> serials = {"cam00", "cam02", "cam04"};
  stuck.send(zmq::buffer(*wire::encode_watch({{MessageKind::Outline}, serials})));
  zmq::pollitem_t item{stuck.handle(), 0, ZMQ_POLLIN, 0};
  ASSERT_TRUE(eventually(
      [&] {
        wire::wait_for(std::span(&item, 1), std::chrono::milliseconds(100));
        return (item.revents & ZMQ_POLLIN) != 0;
      },
      kPatience))
      << "it is served";

  const Result<std::unique_ptr<wire::Subscriber>> reader =
      wire::Subscriber::connect({{studio_.node_address(kLeft)}, studio_.keys, {MessageKind::Outline}, 8});
  ASSERT_THAT(reader, IsOk());
  (*reader)->want_tiles(serials);
  constexpr std::uint64_t kEnough = 300;
  EXPECT_TRUE(eventually(
      [&] {
        scenes_->newest(now() + milliseconds(20));
        return (*reader)->counters().messages >= kEnough;
      },
      kPatience))
      << (*reader)->counters().messages;
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_THAT(control(kLeft).stop_recording(), IsOk());
  expect_no_silent_loss(take, true);
  const nlohmann::json told = end(*left_, "node0");
  EXPECT_EQ(told["published"]["dropped"], 0) << "nobody waited for it";
  std::uint64_t got = 0;
  for (zmq::message_t message; stuck.recv(message, zmq::recv_flags::dontwait);) ++got;
  EXPECT_LT(got, kEnough) << "the rest was never stored for it";
}

}  // namespace
}  // namespace floatstage::studio
