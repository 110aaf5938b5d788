#include <gtest/gtest.h>

#include "core/file.h"
#include "pipeline/plan/plan.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

class APlanFile : public testing::Test {
 protected:
  void SetUp() override {
    plan_.folder = folder_.path();
    plan_.command = {"process", "take"};
    plan_.items = {{.id = "mattes-cam01-0", .stage = "mattes", .cameras = {"cam01"}, .count = 2},
                   {.id = "finish", .stage = "finish", .cameras = {}}};
  }
  void expect_refused(const std::string& why) {
    ASSERT_THAT(save_plan(plan_), IsOk());
    EXPECT_THAT(load_plan(folder_.path()), FailsWith(ErrorCode::BadData, why));
  }

  TempFolder folder_;
  Plan plan_;
};

TEST_F(APlanFile, ComesBack) {
  plan_.remarks = {"keys do not hold"};
  ASSERT_THAT(save_plan(plan_), IsOk());
  const Result<Plan> back = load_plan(folder_.path());
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->command, plan_.command);
  EXPECT_EQ(back->remarks, plan_.remarks);
  ASSERT_EQ(back->items.size(), 2u);
  EXPECT_EQ(back->items[0].frames(), (std::vector<int>{0, 1}));
}

TEST_F(APlanFile, WhoseItemsLeadOutOfItIsRefused) {
  plan_.items[0].id = "../../elsewhere";
  expect_refused("'../../elsewhere' names no item");
}

TEST_F(APlanFile, OfFramesThatNoTakeHasIsRefused) {
  plan_.items[0].count = 2'000'000'000;
  expect_refused("frames that no take has");
  plan_.items[0] = {
      .id = "m", .stage = "mattes", .cameras = {}, .first = 0, .count = 2, .step = 2'000'000'000};
  expect_refused("frames that no take has");
  plan_.items[0].step = 0;
  expect_refused("frames that no take has");
}

TEST_F(APlanFile, WithoutItemsIsRefused) {
  plan_.items.clear();
  expect_refused("no items");
}

TEST_F(APlanFile, AnItemThatEndedWithNoErrorOfOursIsRefused) {
  ASSERT_THAT(save_plan(plan_), IsOk());
  ASSERT_THAT(write_file(plan_.result("finish"),
                         R"({"state": "failed", "attempts": 1, "node": "n", "seconds": 1, "bytes": 0,
                             "error": {"code": 77, "name": "io", "message": "what"}})"),
              IsOk());
  EXPECT_THAT(load_result(plan_, "finish"), FailsWith(ErrorCode::BadData, "error 77"));
}

}  // namespace
}  // namespace floatstage::pipeline
