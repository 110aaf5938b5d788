// Every reason for a FAIL has a row in docs/calibration-failures.md that says what to do.

#include <map>
#include <regex>
#include <set>

#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"

namespace floatstage::pipeline {
namespace {

std::string source(const char* path) {
  const Result<std::string> bytes = read_file(source_folder() / path);
  EXPECT_THAT(bytes, IsOk());
  return bytes ? *bytes : "";
}

// The first cell of every row, and the last one.
std::map<std::string, std::string> rows() {
  std::map<std::string, std::string> out;
  const std::string page = source("docs/calibration-failures.md");
  static const std::regex row(R"((?:^|\n)\| `([^`]+)` \|.*\| ([^|\n]+) \|(?=\n))");
  for (std::sregex_iterator it(page.begin(), page.end(), row), end; it != end; ++it) out[(*it)[1]] = (*it)[2];
  return out;
}

TEST(FailureDocs, HaveARowForEveryNamedFailure) {
  const auto documented = rows();
  int failures = 0;
  for (; calib::name_of(static_cast<calib::CalibrationFailure>(failures)) != std::string("unknown");
       ++failures) {
    const std::string name = calib::name_of(static_cast<calib::CalibrationFailure>(failures));
    ASSERT_TRUE(documented.contains(name)) << name;
    EXPECT_GT(documented.at(name).size(), 20u) << name << ": what is to be done?";
  }
  EXPECT_GE(failures, 6);
}

TEST(FailureDocs, HaveARowForEveryBarOfASession) {
  const auto documented = rows();
  const std::string session = source("pipeline/calibrate/session.cpp");
  static const std::regex key(R"re(t\.number\("([a-z0-9_]+)",\s*b\.)re");
  int bars = 0;
  for (std::sregex_iterator it(session.begin(), session.end(), key), end; it != end; ++it, ++bars)
    EXPECT_TRUE(documented.contains((*it)[1])) << (*it)[1];
  EXPECT_GE(bars, 9);
}

TEST(FailureDocs, HaveARowForEveryBarThatIsChecked) {
  const auto documented = rows();
  std::set<std::string> checked;
  for (const char* file : {"pipeline/calibrate/verdict.cpp", "apps/calibrate/session_verb.cpp"}) {
    const std::string code = source(file);
    static const std::regex name(
        R"re((?:check\(|\{|what = )"([a-z0-9]+(?:_[a-z0-9]+)*_(?:px|percent|mm|degrees|ratio|ms))")re");
    for (std::sregex_iterator it(code.begin(), code.end(), name), end; it != end; ++it)
      checked.insert((*it)[1]);
  }
  EXPECT_GE(checked.size(), 9u);
  for (const std::string& name : checked) EXPECT_TRUE(documented.contains(name)) << name;
}

}  // namespace
}  // namespace floatstage::pipeline
