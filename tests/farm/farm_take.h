#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/text.h"
#include "tests/farm/quoted.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage {

/// Runs the program with these words.
inline Ended floatstage(const std::string& words) { return run_command(FLOATSTAGE_PROGRAM " " + words); }

/// A small take that was only recorded: 5 cameras, so many instants.
inline std::filesystem::path recorded_take(const TempFolder& folder, const std::string& name, int frames) {
  const std::filesystem::path take = folder / name;
  const Ended made = floatstage(
      text("-q synthesize -o ", quoted(take), " --camera-count 5 --frame-count ", frames, " --size 160x120"));
  EXPECT_EQ(made.code, 0) << made.output;
  std::filesystem::remove_all(take / "mattes");
  std::filesystem::remove_all(take / "meshes");
  return take;
}

inline std::filesystem::path copy_of(const std::filesystem::path& take, const std::string& name) {
  const std::filesystem::path copy = take.parent_path() / name;
  std::filesystem::copy(take, copy, std::filesystem::copy_options::recursive);
  return copy;
}

/// Everything that was derived from a take, by name: bytes, but for the seconds that a hull took.
inline std::map<std::string, std::string> derived_files(const std::filesystem::path& take) {
  std::map<std::string, std::string> files;
  for (const char* folder : {"mattes", "meshes"}) {
    if (!std::filesystem::exists(take / folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(take / folder)) {
      if (!entry.is_regular_file()) continue;
      const std::string name = std::filesystem::relative(entry.path(), take).string();
      const Result<std::string> bytes = read_file(entry.path());
      EXPECT_THAT(bytes, IsOk());
      files[name] = bytes ? *bytes : "";
      if (name != "meshes/hull.json") continue;
      nlohmann::json record = nlohmann::json::parse(files[name]);
      for (nlohmann::json& frame : record.at("frames")) frame.erase("seconds");
      files[name] = record.dump(1);
    }
  }
  return files;
}

/// What `plan show --json` says.
inline nlohmann::json shown(const std::filesystem::path& plan) {
  const std::filesystem::path file = plan.string() + ".json";
  const Ended said = floatstage(text("plan show ", quoted(plan), " --json ", quoted(file)));
  EXPECT_EQ(said.code, 0) << said.output;
  const Result<std::string> bytes = read_file(file);
  EXPECT_THAT(bytes, IsOk());
  return bytes ? nlohmann::json::parse(*bytes) : nlohmann::json();
}

}  // namespace floatstage
