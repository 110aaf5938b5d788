#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/command_line.h"
#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {

/// Verbs as a user says them, in a folder of their own.
class VerbRuns : public testing::Test {
 protected:
  static Result<void> run(const std::vector<std::string>& words) {
    Chosen chosen;
    const std::unique_ptr<CLI::App> app = command_line(chosen);
    const std::optional<Ending> ending = read_command_line(*app, words);
    if (ending) return fail(ErrorCode::InvalidArgument, ending->error);
    return chosen.run();
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  nlohmann::json report(const std::string& name) const {
    const Result<std::string> text = read_file(folder_ / name);
    EXPECT_THAT(text, IsOk());
    return text ? nlohmann::json::parse(*text) : nlohmann::json();
  }

  TempFolder folder_;
};

}  // namespace floatstage::apps
