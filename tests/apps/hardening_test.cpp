#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/run_command.h"
#include "tests/support/sanitized.h"

// What ADR 0253 promises of the program as it was linked and of the unit that runs it, and that another
// folder makes the same bytes.
namespace floatstage {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

std::string readelf(const std::string& what) {
  return run_command("readelf --wide " + what + " " FLOATSTAGE_PROGRAM).output;
}

// Of what users run.
class HardenedProgram : public testing::Test {
 protected:
  void SetUp() override {
    if (kSanitized) GTEST_SKIP() << "a sanitized program is linked in its own way";
  }
};

TEST_F(HardenedProgram, HasRelocationsSealedBeforeMain) {
  EXPECT_THAT(readelf("--dynamic"),
              AllOf(ContainsRegex("\\(FLAGS\\) .*BIND_NOW"), ContainsRegex("\\(FLAGS_1\\) .*NOW.*PIE")));
  EXPECT_THAT(readelf("--segments"), AllOf(HasSubstr("GNU_RELRO"), ContainsRegex("GNU_STACK .* RW  "),
                                           Not(ContainsRegex("GNU_STACK .* RWE"))));
}

TEST_F(HardenedProgram, GuardsItsStackAndItsCopies) {
  EXPECT_THAT(readelf("--dyn-syms"), AllOf(HasSubstr("__stack_chk_fail"), ContainsRegex("__[a-z]+_chk@"),
                                           HasSubstr("__glibcxx_assert_fail")));
}

TEST_F(HardenedProgram, TellsNothingOfTheFolderThatItWasBuiltIn) {
  EXPECT_THAT(
      run_command(
          "strings " FLOATSTAGE_PROGRAM " | grep -E "
          "'/(core|capture|calib|matting|detail|recon|render|pipeline|studio|apps)/[a-z_/]*\\.(h|cpp)$'")
          .output,
      testing::IsEmpty());
}

TEST(Hardening, TheUnitOfACameraNodeMayDoLittle) {
  const std::string judged = run_command("systemd-analyze security --offline=true " FLOATSTAGE_UNIT).output;
  std::smatch level;
  ASSERT_TRUE(std::regex_search(judged, level, std::regex("exposure level for .*: ([0-9.]+) "))) << judged;
  EXPECT_LE(std::stod(level[1]), 2.5) << judged;
}

}  // namespace
}  // namespace floatstage
