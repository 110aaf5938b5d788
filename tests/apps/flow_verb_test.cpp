#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "render/flow/flo_file.h"
#include "tests/apps/verb_runs.h"
#include "tests/render/flow/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

constexpr int kWidth = 120, kHeight = 90;

class FlowVerb : public VerbRuns {
 protected:
  // A grainy picture, moved to the right and down.
  std::string picture(const std::string& name, int dx, int dy) {
    Image image(kWidth, kHeight, 1);
    image.pixels = render::test::grainy(kWidth, kHeight, dx, dy);
    EXPECT_THAT(save_png(image, folder_ / name), IsOk());
    return file(name);
  }
};

TEST_F(FlowVerb, FindsAShiftAndWritesItsFieldColoursAndReport) {
  const std::string a = picture("a.png", 0, 0), b = picture("b.png", 4, -2);
  ASSERT_THAT(
      run({"flow", a, b, "--out", file("f.flo"), "--picture", file("f.png"), "--json", file("f.json")}),
      IsOk());
  const Result<render::FlowField> field = render::load_flo(file("f.flo"));
  ASSERT_THAT(field, IsOk());
  const std::size_t middle = 2 * (kHeight / 2 * kWidth + kWidth / 2);
  EXPECT_NEAR(field->uv[middle], 4, 0.05);
  EXPECT_NEAR(field->uv[middle + 1], -2, 0.05);
  const Result<Image> colors = load_png(file("f.png"));
  ASSERT_THAT(colors, IsOk());
  EXPECT_EQ(colors->width, kWidth);
  EXPECT_EQ(colors->channels, 3);
  const nlohmann::json made = report("f.json");
  EXPECT_GT(made.at("seconds"), 0);
  EXPECT_FALSE(made.contains("epe")) << "there is no truth to compare with";
}

TEST_F(FlowVerb, ScoresAgainstATruth) {
  const std::string a = picture("a.png", 0, 0), b = picture("b.png", 3, 0);
  render::FlowField truth{kWidth, kHeight, std::vector<float>(2 * kWidth * kHeight, 0)};
  for (std::size_t i = 0; i < truth.uv.size(); i += 2) truth.uv[i] = 3;
  truth.uv[0] = 2e9F;  // not known
  ASSERT_THAT(render::save_flo(truth, file("truth.flo")), IsOk());
  for (const char* flow : {"variational", "dis"})
    for (const char* preset : {"quality", "fast"}) {
      ASSERT_THAT(run({"flow", a, b, "--flow", flow, "--preset", preset, "--truth", file("truth.flo"),
                       "--json", file("f.json")}),
                  IsOk())
          << flow << " " << preset;
      const nlohmann::json made = report("f.json");
      EXPECT_EQ(made.at("known"), kWidth * kHeight - 1);
      EXPECT_LT(made.at("epe"), 0.3) << flow << " " << preset;
      EXPECT_LT(made.at("aae"), 8) << flow << " " << preset;
    }
}

TEST_F(FlowVerb, OfAPictureToItselfIsZero) {
  const std::string a = picture("a.png", 0, 0);
  ASSERT_THAT(run({"flow", a, a, "-o", file("f.flo")}), IsOk());
  EXPECT_THAT(render::load_flo(file("f.flo"))->uv, testing::Each(0.F));
}

TEST_F(FlowVerb, NamesTheFileThatDoesNotFitAndWritesNothing) {
  const std::string a = picture("a.png", 0, 0);
  ASSERT_THAT(save_png(Image(20, 10, 3), file("small.png")), IsOk());
  render::FlowField small{2, 2, std::vector<float>(8)};
  ASSERT_THAT(render::save_flo(small, file("small.flo")), IsOk());
  EXPECT_THAT(run({"flow", a, file("small.png"), "-o", file("f.flo")}),
              FailsWith(ErrorCode::InvalidArgument, "small.png has 20x10 px"));
  EXPECT_THAT(run({"flow", a, a, "--truth", file("small.flo"), "-o", file("f.flo")}),
              FailsWith(ErrorCode::InvalidArgument, "small.flo has 2x2 px"));
  EXPECT_THAT(run({"flow", a, file("none.png")}), FailsWith(ErrorCode::NotFound, "none.png"));
  EXPECT_THAT(run({"flow", a, a, "--preset", "medium"}), FailsWith(ErrorCode::InvalidArgument, "medium"));
  EXPECT_FALSE(std::filesystem::exists(file("f.flo")));
}

}  // namespace
}  // namespace floatstage::apps
