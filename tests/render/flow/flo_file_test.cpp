#include "render/flow/flo_file.h"

#include <cmath>
#include <limits>

#include "core/file.h"
#include "render/flow/flow_score.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::render::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kNone = 1e10F;

FlowField three_by_two() { return {3, 2, {0, 0, 1.5, -2, kNone, kNone, -4, 3, 0.25, 0, 7, 7}}; }

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST(FloFile, ComesBackBitByBit) {
  const TempFolder folder;
  ASSERT_THAT(save_flo(three_by_two(), folder / "field.flo"), IsOk());
  const Result<FlowField> back = load_flo(folder / "field.flo");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->width, 3);
  EXPECT_EQ(back->height, 2);
  EXPECT_EQ(back->uv, three_by_two().uv);
}

TEST(FloFile, BeginsAsMiddleburyHasIt) {
  const std::string bytes = encode_flo(three_by_two());
  EXPECT_EQ(bytes.substr(0, 4), "PIEH");
  EXPECT_EQ(bytes.size(), 12u + 6 * 8);
  EXPECT_EQ(bytes[4], 3);
  EXPECT_EQ(bytes[8], 2);
}

TEST(FloFile, RefusesEveryTruncation) {
  const std::string whole = encode_flo(three_by_two());
  ASSERT_THAT(decode_flo(bytes_of(whole), "whole"), IsOk());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(decode_flo(bytes_of(whole.substr(0, size)), "cut.flo"),
                FailsWith(ErrorCode::BadData, "cut.flo"))
        << size;
  EXPECT_THAT(decode_flo(bytes_of(whole + "x"), "long.flo"), FailsWith(ErrorCode::BadData, "long.flo"));
}

TEST(FloFile, RefusesSizesThatMakeNoSense) {
  for (const auto& [width, height] : {std::pair(0, 2), std::pair(-3, 2), std::pair(1 << 30, 1 << 30)}) {
    std::string bytes = encode_flo(three_by_two());
    for (int i = 0; i < 4; ++i) {
      bytes[static_cast<std::size_t>(4 + i)] = static_cast<char>(width >> (8 * i));
      bytes[static_cast<std::size_t>(8 + i)] = static_cast<char>(height >> (8 * i));
    }
    EXPECT_THAT(decode_flo(bytes_of(bytes), "odd.flo"), FailsWith(ErrorCode::BadData, "odd.flo"));
  }
  EXPECT_THAT(save_flo({}, "nowhere.flo"), FailsWith(ErrorCode::InvalidArgument, "without pixels"));
  EXPECT_THAT(load_flo("/no/such/field.flo"), FailsWith(ErrorCode::NotFound, "/no/such/field.flo"));
}

TEST(FlowScore, IsTheMeanOverWhatIsKnown) {
  FlowField field = three_by_two();
  for (std::size_t i = 0; i < field.uv.size(); i += 2) field.uv[i] += 3, field.uv[i + 1] += 4;
  const Result<FlowScore> score = score_flow(field, three_by_two());
  ASSERT_THAT(score, IsOk());
  EXPECT_EQ(score->known, 5u);
  EXPECT_NEAR(score->epe, 5, 1e-6);
  EXPECT_THAT(score_flow({1, 1, {0, 0}}, three_by_two()), FailsWith(ErrorCode::InvalidArgument, "1x1"));
}

TEST(FlowScore, MeasuresAnglesInSpaceAndTime) {
  const auto angle = [](float u, float v, float tu, float tv) {
    return score_flow({1, 1, {u, v}}, {1, 1, {tu, tv}})->aae;
  };
  EXPECT_EQ(angle(2, 3, 2, 3), 0);
  EXPECT_NEAR(angle(0, 0, 1, 0), 45, 1e-6);
  EXPECT_NEAR(angle(1, 0, 0, 1), 60, 1e-6);
}

TEST(FlowScore, SaysThatNothingIsKnown) {
  const FlowField none{1, 1, {kNone, 0}};
  const Result<FlowScore> score = score_flow(none, none);
  ASSERT_THAT(score, IsOk());
  EXPECT_EQ(score->known, 0u);
  EXPECT_TRUE(std::isnan(score->epe));
  EXPECT_FALSE(is_known(std::numeric_limits<float>::quiet_NaN(), 0));
}

TEST(FlowPicture, ShowsDirectionAsHueAndRestAsWhite) {
  const auto color = [](float u, float v) {
    const Image picture = flow_picture({1, 1, {u, v}}, 1);
    return std::vector<int>(picture.pixels.begin(), picture.pixels.end());
  };
  EXPECT_THAT(color(0, 0), ElementsAre(255, 255, 255));
  EXPECT_THAT(color(1, 0), ElementsAre(255, 0, 0)) << "to the right is red";
  EXPECT_THAT(color(-1, 0), ElementsAre(0, 209, 255)) << "to the left cyan";
  EXPECT_THAT(color(kNone, 0), ElementsAre(0, 0, 0)) << "not known";
  const std::vector<int> down = color(0, 1), up = color(0, -1);
  EXPECT_GT(down[0], down[2]) << "down is yellow";
  EXPECT_GT(up[2], up[1]) << "up is violet";
}

}  // namespace
}  // namespace floatstage::render::test
