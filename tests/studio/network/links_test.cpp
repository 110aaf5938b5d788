#include <gtest/gtest.h>

#include "studio/network/publisher.h"
#include "studio/network/subscriber.h"
#include "tests/studio/messages/views.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

using View = std::shared_ptr<const CameraView>;

constexpr const char* kAnyPort = "tcp://127.0.0.1:0";

std::unique_ptr<Publisher> publisher(PublisherOptions options = {}) {
  if (options.address == PublisherOptions().address) options.address = kAnyPort;
  Result<std::unique_ptr<Publisher>> bound = Publisher::bind(options);
  EXPECT_THAT(bound, IsOk());
  return std::move(*bound);
}

std::unique_ptr<Subscriber> subscriber(const std::string& address, std::vector<MessageKind> kinds,
                                       const std::optional<StudioKeys>& keys = {}) {
  Result<std::unique_ptr<Subscriber>> connected =
      Subscriber::connect({{address}, keys, std::move(kinds), 64});
  EXPECT_THAT(connected, IsOk());
  return std::move(*connected);
}

View view_of(const std::string& serial, std::uint64_t epoch) {
  return std::make_shared<const CameraView>(small_view(serial, epoch));
}

// Publishes until the first one arrives: a subscription needs a moment on its way. Gives that one.
std::optional<Received> first(Publisher& from, Subscriber& to, const std::string& serial,
                              std::uint64_t epoch = 0) {
  std::optional<Received> received;
  eventually([&] {
    from.publish(view_of(serial, epoch));
    received = to.next(milliseconds(20));
    return received.has_value();
  });
  return received;
}

void drain(Subscriber& to) {
  while (to.next(milliseconds(50))) {
  }
}

TEST(Links, BringOutlinesToWhoeverListensAndNoTileThatNobodyAskedFor) {
  const auto node = publisher();
  const auto recon = subscriber(node->address(), {MessageKind::Outline});
  const std::optional<Received> received = first(*node, *recon, "cam1", 5);
  ASSERT_TRUE(received);
  const View view = std::get<View>(*received);
  EXPECT_EQ(view->serial, "cam1");
  EXPECT_EQ(view->epoch, 5u);
  EXPECT_EQ(view->outline.points, small_view("cam1").outline.points);
  EXPECT_EQ(view->tile, nullptr);
  EXPECT_GT(node->counters().outlines, 0u);
  EXPECT_EQ(node->counters().tiles, 0u) << "though every view had one";
  EXPECT_FALSE(node->wants_tile("cam1"));
}

TEST(Links, BringTheTilesOfTheCamerasThatWereAskedForAndOfNoOther) {
  const auto node = publisher({.tiles = {TileCode::Raw, 0}});
  const auto viewer = subscriber(node->address(), {});
  viewer->want_tiles({"cam1", "cam3"});
  ASSERT_TRUE(eventually([&] { return node->wants_tile("cam1") && node->wants_tile("cam3"); }));
  EXPECT_FALSE(node->wants_tile("cam2"));
  EXPECT_FALSE(node->wants_tile("cam10")) << "its name begins like another's";
  for (std::uint64_t epoch = 0; epoch < 5; ++epoch)
    for (const char* serial : {"cam0", "cam1", "cam10", "cam2", "cam3"})
      node->publish(view_of(serial, epoch));
  for (int i = 0; i < 10; ++i) {
    const std::optional<Received> received = viewer->next(milliseconds(5000));
    ASSERT_TRUE(received);
    const View view = std::get<View>(*received);
    EXPECT_EQ(view->serial, i % 2 == 0 ? "cam1" : "cam3");
    EXPECT_EQ(view->epoch, static_cast<std::uint64_t>(i / 2));
    EXPECT_EQ(view->tile->picture, small_view("cam1").tile->picture);
  }
  EXPECT_FALSE(viewer->next(milliseconds(20)));
  EXPECT_EQ(node->counters().tiles, 10u);
  EXPECT_EQ(viewer->counters().tile_bytes, node->counters().tile_bytes);
  EXPECT_EQ(viewer->counters().missed, 0u);
}

TEST(Links, StopTilesWhenAViewerTurnsAwayOrLeaves) {
  const auto node = publisher();
  auto viewer = subscriber(node->address(), {});
  viewer->want_tiles({"cam1"});
  ASSERT_TRUE(eventually([&] { return node->wants_tile("cam1"); }));
  viewer->want_tiles({"cam2"});
  ASSERT_TRUE(eventually([&] { return node->wants_tile("cam2") && !node->wants_tile("cam1"); }));
  viewer.reset();
  EXPECT_TRUE(eventually([&] { return !node->wants_tile("cam2"); }));
}

TEST(Links, GatherSeveralNodesAndBringScenesAndStatus) {
  const auto left = publisher(), right = publisher();
  Result<std::unique_ptr<Subscriber>> both =
      Subscriber::connect({{left->address(), right->address()},
                           {},
                           {MessageKind::Outline, MessageKind::Scene, MessageKind::Status},
                           64});
  ASSERT_THAT(both, IsOk());
  ASSERT_TRUE(first(*left, **both, "cam0"));
  drain(**both);
  const std::optional<Received> other = first(*right, **both, "cam1");
  ASSERT_TRUE(other);
  EXPECT_EQ(std::get<View>(*other)->serial, "cam1");
  drain(**both);
  NodeStatus status;
  status.node = "left";
  left->publish(status);
  std::optional<Received> received = (*both)->next(milliseconds(5000));
  ASSERT_TRUE(received);
  EXPECT_EQ(std::get<NodeStatus>(*received).node, "left");
  StudioScene scene;
  scene.epoch = 44;
  scene.rig_sha256 = std::string(64, '0');
  right->publish(std::make_shared<const StudioScene>(scene));
  received = (*both)->next(milliseconds(5000));
  ASSERT_TRUE(received);
  EXPECT_EQ(std::get<std::shared_ptr<const StudioScene>>(*received)->epoch, 44u);
}

TEST(Links, FindANodeAgainThatWasStartedAgain) {
  auto node = publisher();
  const std::string address = node->address();
  const auto recon = subscriber(address, {MessageKind::Outline});
  ASSERT_TRUE(first(*node, *recon, "cam1"));
  node.reset();
  drain(*recon);
  node = publisher({.address = address});
  const std::optional<Received> again = first(*node, *recon, "cam1", 77);
  ASSERT_TRUE(again);
  EXPECT_EQ(std::get<View>(*again)->epoch, 77u);
  EXPECT_EQ(recon->counters().missed, 0u) << "its numbers begin again";
}

TEST(Links, DropTheOldestWhereNobodyFetchesAndSaySo) {
  const auto node = publisher();
  Result<std::unique_ptr<Subscriber>> slow =
      Subscriber::connect({{node->address()}, {}, {MessageKind::Outline}, 3});
  ASSERT_THAT(slow, IsOk());
  ASSERT_TRUE(first(*node, **slow, "cam1"));
  drain(**slow);
  const std::uint64_t before = (*slow)->counters().outlines;
  for (std::uint64_t epoch = 100; epoch < 110; ++epoch) node->publish(view_of("cam1", epoch));
  ASSERT_TRUE(eventually([&] { return (*slow)->counters().outlines == before + 10; }));
  EXPECT_TRUE(eventually([&] { return (*slow)->counters().dropped == 7; }));
  for (std::uint64_t epoch : {107u, 108u, 109u})
    EXPECT_EQ(std::get<View>(*(*slow)->next(milliseconds(5000)))->epoch, epoch);
}

TEST(Links, CountWhatCannotBeAMessage) {
  const auto node = publisher();
  node->publish(view_of(std::string(60, 'x'), 0));
  EXPECT_TRUE(eventually([&] { return node->counters().unsendable == 1; }));
}

TEST(Links, ToAnAddressThatOthersReachNeedKeys) {
  EXPECT_THAT(Publisher::bind({.address = "tcp://0.0.0.0:0"}),
              FailsWith(ErrorCode::InvalidArgument, "floatstage keys"));
  EXPECT_THAT(Subscriber::connect({{"tcp://10.1.2.3:5570"}, {}, {}, 8}),
              FailsWith(ErrorCode::InvalidArgument, "floatstage keys"));
  EXPECT_THAT(Subscriber::connect({}), FailsWith(ErrorCode::InvalidArgument, "no address"));
  const auto node = publisher();
  EXPECT_THAT(Publisher::bind({.address = node->address()}),
              FailsWith(ErrorCode::Io, "cannot be listened on"));
}

TEST(Links, WithKeysAreForWhoeverHasThem) {
  const StudioKeys keys = *make_keys();
  const auto node = publisher({.keys = keys});
  const auto recon = subscriber(node->address(), {MessageKind::Outline}, keys);
  EXPECT_TRUE(first(*node, *recon, "cam1"));
  EXPECT_EQ(node->counters().refused, 0u);
}

TEST(Links, RefuseAndCountWhoHasOtherKeysOrNone) {
  const StudioKeys keys = *make_keys(), others = *make_keys();
  // Knows the node's key from somewhere, and has none of the studio's own.
  const StudioKeys half{keys.public_key, others.secret_key};
  const auto node = publisher({.keys = keys});
  const auto friendly = subscriber(node->address(), {MessageKind::Outline}, keys);
  ASSERT_TRUE(first(*node, *friendly, "cam1"));
  std::uint64_t refused = 0;
  for (const std::optional<StudioKeys>& wrong :
       {std::optional(others), std::optional(half), std::optional<StudioKeys>()}) {
    const auto stranger = subscriber(node->address(), {MessageKind::Outline}, wrong);
    EXPECT_TRUE(eventually([&] { return node->counters().refused > refused; }));
    node->publish(view_of("cam1", 9));
    EXPECT_TRUE(friendly->next(milliseconds(5000)));
    EXPECT_FALSE(stranger->next(milliseconds(50)));
    refused = node->counters().refused;
  }
}

}  // namespace
}  // namespace floatstage::studio::wire
