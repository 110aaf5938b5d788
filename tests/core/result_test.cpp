#include "core/result.h"

#include <memory>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return fail(ErrorCode::InvalidArgument, "an odd number");
  return n / 2;
}

Result<std::string> half_in_words(int n) {
  const Result<int> h = half(n);
  if (!h) return forward(h);
  return std::to_string(*h);
}

TEST(Result, HoldsAValueOrAnError) {
  EXPECT_THAT(half(8), IsOkAnd(testing::Eq(4)));
  EXPECT_THAT(half(7), FailsWith(ErrorCode::InvalidArgument, "an odd number"));
}

TEST(Result, ForwardsTheErrorOfAnotherType) {
  EXPECT_THAT(half_in_words(7), FailsWith(ErrorCode::InvalidArgument, "an odd number"));
}

TEST(Result, GivesItsValueAwayWhenMovedFrom) {
  Result<std::unique_ptr<int>> r = std::make_unique<int>(5);
  const std::unique_ptr<int> taken = *std::move(r);
  EXPECT_EQ(*taken, 5);
}

TEST(Result, ThrowsWhenTheSideThatIsNotThereIsRead) {
  const Result<int> error = half(7), value = half(8);
  EXPECT_THROW(error.value(), CheckFailure);
  EXPECT_THROW(*error, CheckFailure);
  EXPECT_THROW(value.error(), CheckFailure);
  EXPECT_THROW(Result<void>().error(), CheckFailure);
}

TEST(Result, MisreadSaysWhichErrorWasThere) {
  try {
    half(7).value();
    FAIL();
  } catch (const CheckFailure& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("an odd number"));
  }
}

TEST(Result, OfVoidIsSuccessOrAnError) {
  EXPECT_THAT(Result<void>(), IsOk());
  EXPECT_THAT(Result<void>(fail(ErrorCode::Io, "disk full")), FailsWith(ErrorCode::Io, "disk full"));
}

TEST(ErrorCode, HasANameOfItsOwn) {
  std::set<std::string> names;
  for (int i = 0; i <= static_cast<int>(ErrorCode::Cancelled); ++i)
    names.insert(name_of(static_cast<ErrorCode>(i)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(ErrorCode::Cancelled) + 1);
  EXPECT_FALSE(names.contains("unknown"));
  EXPECT_TRUE(names.contains("bad-data"));
}

TEST(Check, NamesConditionPlaceAndContext) {
  const int cameras = 3;
  try {
    FLOATSTAGE_CHECK(cameras == 4, "cameras: " + std::to_string(cameras));
    FAIL() << "a false check went through";
  } catch (const CheckFailure& e) {
    EXPECT_THAT(e.what(),
                testing::AllOf(testing::HasSubstr("cameras == 4"), testing::HasSubstr("result_test.cpp"),
                               testing::HasSubstr("cameras: 3")));
  }
}

TEST(Check, DoesNotBuildItsContextWhileTheConditionHolds) {
  bool built = false;
  auto context = [&] {
    built = true;
    return "x";
  };
  FLOATSTAGE_CHECK(1 + 1 == 2, context());
  EXPECT_FALSE(built);
}

}  // namespace
}  // namespace floatstage
