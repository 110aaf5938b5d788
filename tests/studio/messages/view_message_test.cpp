#include "studio/messages/view_message.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"
#include "studio/messages/outline_code.h"
#include "tests/studio/messages/views.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

CameraView read(const Result<std::string>& bytes) {
  EXPECT_THAT(bytes, IsOk());
  const Result<Message> message = open(*bytes);
  EXPECT_THAT(message, IsOk());
  const Result<CameraView> view = decode_view(*message);
  EXPECT_THAT(view, IsOk());
  return view ? *view : CameraView{};
}

Result<CameraView> try_to_read(std::string_view bytes) {
  const Result<Message> message = open(bytes);
  if (!message) return forward(message);
  return decode_view(*message);
}

void expect_same_facts(const CameraView& a, const CameraView& b) {
  EXPECT_EQ(a.serial, b.serial);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.instant, b.instant);
  EXPECT_EQ(a.exposed, b.exposed);
  EXPECT_EQ(a.produced, b.produced);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.known, b.known);
}

TEST(OutlineMessage, CarriesEverythingButTheTile) {
  const CameraView view = small_view("cam3");
  const CameraView again = read(encode_outline(view));
  expect_same_facts(again, view);
  EXPECT_EQ(again.outline.points, view.outline.points);
  EXPECT_EQ(again.outline.starts, view.outline.starts);
  EXPECT_FALSE(again.outline.beyond_counts);
  EXPECT_EQ(again.tile, nullptr);
}

TEST(OutlineMessage, SaysThatTheSubjectIsCutAndThatACameraMissedTheInstant) {
  CameraView cut = small_view("cam3");
  cut.outline.beyond_counts = true;
  EXPECT_TRUE(read(encode_outline(cut)).outline.beyond_counts);
  CameraView missed = small_view("cam3");
  missed.known = false;
  missed.outline.clear();
  const CameraView again = read(encode_outline(missed));
  EXPECT_FALSE(again.known);
  EXPECT_TRUE(again.outline.empty());
  EXPECT_EQ(again.outline.polygons(), 0);
}

TEST(OutlineMessage, MovesNoPointByMoreThanHalfAStepAndNoneASecondTime) {
  CameraView view = small_view("cam3");
  Random random(3);
  view.outline.clear();
  view.outline.starts = {0};
  for (int p = 0; p < 20; ++p) {
    for (int i = 0; i < 50; ++i)
      view.outline.points.emplace_back(random.uniform(-900, 5000), random.uniform(-900, 5000));
    view.outline.starts.push_back(static_cast<int>(view.outline.points.size()));
  }
  const CameraView once = read(encode_outline(view));
  ASSERT_EQ(once.outline.points.size(), view.outline.points.size());
  for (std::size_t i = 0; i < view.outline.points.size(); ++i)
    EXPECT_LE((once.outline.points[i] - view.outline.points[i]).cwiseAbs().maxCoeff(), 0.5 / kOutlineSteps);
  EXPECT_EQ(read(encode_outline(once)).outline.points, once.outline.points);
}

TEST(OutlineMessage, TakesAboutFourBytesForAPointOfAnOutline) {
  CameraView view = small_view("cam3");
  view.outline.clear();
  for (int i = 0; i < 400; ++i)
    view.outline.points.emplace_back(500 + 200 * std::cos(i * 0.0157), 400 + 200 * std::sin(i * 0.0157));
  view.outline.starts = {0, 400};
  EXPECT_LT(encode_outline(view)->size(), kHeaderBytes + 400 * 4 + 16);
}

TEST(OutlineMessage, RefusesPointsThatAreNone) {
  CameraView view = small_view("cam3");
  view.outline.points[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(encode_outline(view),
              FailsWith(ErrorCode::InvalidArgument, "camera 'cam3': an outline's point"));
  view.outline.points[2].x() = 2 * kFurthestPoint;
  EXPECT_THAT(encode_outline(view), FailsWith(ErrorCode::InvalidArgument, "nowhere near"));
  view = small_view("cam3");
  view.outline.starts = {0, 2, 7};
  EXPECT_THAT(encode_outline(view), FailsWith(ErrorCode::InvalidArgument, "fewer than three"));
}

TEST(OutlineMessage, OfTooManyPointsIsRefusedByBothSides) {
  Silhouette outline;
  for (std::size_t i = 0; i <= kMostOutlinePoints; ++i) outline.points.emplace_back(i % 900, i / 900);
  outline.starts = {0, static_cast<int>(outline.points.size())};
  EXPECT_THAT(encode_outline_points(outline), FailsWith(ErrorCode::InvalidArgument, "too many points"));
  std::string code("\0\x01\x81\x80\x08", 5);  // one polygon of 2^17 + 1 points
  code.append(2 * (kMostOutlinePoints + 1), '\0');
  EXPECT_THAT(decode_outline_points(code), FailsWith(ErrorCode::BadData, "too many points"));
}

TEST(OutlineMessage, ThatWandersOffIsRefused) {
  std::string code("\0\x01\x03", 3);
  code.append("\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01", 10);
  code.append(8, '\x02');
  EXPECT_THAT(decode_outline_points(code), FailsWith(ErrorCode::BadData, "far behind"));
}

TEST(TileMessage, RawGivesBackEveryByte) {
  const CameraView view = small_view("cam3");
  const CameraView again = read(encode_tile(view, {TileCode::Raw, 0}));
  expect_same_facts(again, view);
  ASSERT_NE(again.tile, nullptr);
  EXPECT_EQ(again.tile->x, 9);
  EXPECT_EQ(again.tile->y, 8);
  EXPECT_EQ(again.tile->picture, view.tile->picture);
  EXPECT_EQ(again.tile->matte, view.tile->matte);
  EXPECT_TRUE(again.outline.empty());
}

TEST(TileMessage, AsJpegKeepsTheMatteAndNearlyThePicture) {
  const CameraView view = small_view("cam3");
  const CameraView again = read(encode_tile(view, {TileCode::Jpeg, 95}));
  ASSERT_NE(again.tile, nullptr);
  EXPECT_EQ(again.tile->matte, view.tile->matte);
  EXPECT_THAT(again.tile->picture, ImageNear(view.tile->picture, 38.0));
}

TEST(TileMessage, ThatIsNotInItsPhotographIsRefused) {
  for (const auto& [at, value] : {std::pair{1, -1}, {5, 1000}, {9, 0}, {13, 48}, {9, 1 << 30}}) {
    std::string bytes = *encode_tile(small_view("cam3"), {TileCode::Raw, 0});
    const std::int32_t number = value;
    bytes.replace(kHeaderBytes + at, sizeof number, reinterpret_cast<const char*>(&number), sizeof number);
    EXPECT_THAT(try_to_read(bytes), FailsWith(ErrorCode::BadData, "camera 'cam3'")) << at;
  }
}

TEST(TileMessage, WhoseJpegIsOfAnotherSizeIsRefusedBeforeItIsUnpacked) {
  CameraView view = small_view("cam3");
  std::string bytes = *encode_tile(view, {TileCode::Jpeg, 90});
  bytes[kHeaderBytes + 9] = 21;
  EXPECT_THAT(try_to_read(bytes), FailsWith(ErrorCode::BadData, "a JPEG of 22x33 where 21x33 was announced"));
}

TEST(ViewMessages, AreRefusedWhereverTheyAreCut) {
  const CameraView view = small_view("cam3");
  for (const std::string& whole :
       {*encode_outline(view), *encode_tile(view, {TileCode::Raw, 0}), *encode_tile(view, {})})
    for (std::size_t size = kHeaderBytes; size < whole.size(); ++size) {
      std::string cut = whole.substr(0, size);
      const auto payload = static_cast<std::uint32_t>(size - kHeaderBytes);
      cut.replace(52, sizeof payload, reinterpret_cast<const char*>(&payload), sizeof payload);
      EXPECT_THAT(try_to_read(cut), FailsWith(ErrorCode::BadData, "camera 'cam3'")) << size;
    }
}

TEST(ViewMessages, AreNotReadFromOtherKinds) {
  MessageHeader header;
  header.kind = MessageKind::Status;
  const std::string bytes = *seal(header, "{}");
  EXPECT_THAT(try_to_read(bytes), FailsWith(ErrorCode::BadData, "no camera's view"));
}

}  // namespace
}  // namespace floatstage::studio::wire
