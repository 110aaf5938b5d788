// What tells a synthesis from cheats: every one of them fails a gate (../shared/data/detail/panda).

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/detail/synthesis_gates.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::detail::test {
namespace {

using Figures = std::map<std::string, SynthesisFigures>;

// Each of `names` has a smaller figure than the next one.
void expect_order(const Figures& all, double SynthesisFigures::*figure,
                  const std::vector<std::string>& names) {
  for (std::size_t i = 1; i < names.size(); ++i)
    EXPECT_LT(all.at(names[i - 1]).*figure, all.at(names[i]).*figure) << names[i - 1] << " and " << names[i];
}

TEST(TheGatesOfASynthesis, AreFailedByEveryCheatAndPassedByTheTruth) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  const Result<SynthesisProtocol> protocol = panda_protocol();
  ASSERT_THAT(protocol, IsOk());
  const SynthesisJudge judge(*protocol);
  Figures all;
  for (const Variant& v : variants_of(*protocol)) {
    const SynthesisFigures& f = all[v.name] = judge.measure(v.picture);
    RecordProperty(v.name, to_text(f));
    EXPECT_EQ(failed_gates(f).empty(), v.name == "truth") << v.name << ": " << to_text(f);
  }
  ASSERT_EQ(all.size(), 10U);
  // Every figure has an order of its own: none of them tells all cheats from the truth.
  expect_order(all, &SynthesisFigures::sub_bands,
               {"truth", "moved by 1", "moved by 4", "borrowed", "noise", "unsharp", "bicubic", "lanczos"});
  expect_order(all, &SynthesisFigures::from_children,
               {"shuffled", "borrowed", "unsharp", "noise", "lanczos", "bicubic"});
  expect_order(all, &SynthesisFigures::downsampled,
               {"shuffled", "moved by 4", "borrowed", "noise", "bicubic", "lanczos", "moved by 1", "truth"});
  // What ranks wrongly: a blur is nearer to the truth, and to the children, than right details elsewhere.
  expect_order(all, &SynthesisFigures::psnr, {"shuffled", "moved by 4", "borrowed", "noise", "bicubic"});
  expect_order(all, &SynthesisFigures::to_children, {"bicubic", "truth", "borrowed", "shuffled"});
}

TEST(TheGatesOfASynthesis, CountBlocksThatAreCopiedOften) {
  SynthesisProtocol protocol;
  protocol.children = {{0, 100, 64, 164}};
  const int width = 96, height = 96;
  Places places(static_cast<std::size_t>(width) * height, -1);
  const auto copy = [&](int x0, int y0, int side) {
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        places[static_cast<std::size_t>((y0 + y) * width + x0 + x)] = 64 * (y + 9) + x + 9;
  };
  copy(0, 0, 16);
  copy(20, 0, 16);
  EXPECT_EQ(most_used_block(protocol, places, width, height), 0) << "16 x 16 are not counted";
  copy(40, 0, 17);
  copy(60, 0, 20);
  copy(0, 40, 17);
  EXPECT_EQ(most_used_block(protocol, places, width, height), 3);
}

}  // namespace
}  // namespace floatstage::detail::test
