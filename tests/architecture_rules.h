#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

// The rules of docs/architecture.md as functions over text, so that each can be shown a breach that it must
// find.

namespace floatstage::architecture {

struct SourceFile {
  std::string path;  ///< from the root, with forward slashes
  std::string text;
};

struct Include {
  std::string target;
  bool angled = false;  ///< <…> rather than "…"
  int line = 0;         ///< from 1
};

/// The folders that may include nothing of one another.
const std::set<std::string>& stages();

/// The #include lines of a C++ file; those in comments do not count.
std::vector<Include> includes_of(std::string_view cpp);

/// The headers named in the third column of architecture.md's table of folders: "core/rig.h", ….
std::set<std::string> public_headers(std::string_view architecture_md);

// Each returns sentences that begin with the place: "matting/keyers/keyer.cpp:3: …". Empty when the rule is
// kept.

/// Stages include core and themselves; core only core; pipeline and studio lie above the stages, side by
/// side, and apps above both; core/synthetic is for these three, tests and capture's synthetic source;
/// nothing of the product includes tests; of a stage, what is above includes only what is public.
std::vector<std::string> breaches_of_layering(const std::vector<SourceFile>& files,
                                              const std::set<std::string>& public_headers);

/// Each folder inside pipeline, studio and apps has a rank and includes only those of a lower one.
std::vector<std::string> breaches_of_ranks(const std::vector<SourceFile>& files);

/// Only apps names CLI11, GLFW or Dear ImGui.
std::vector<std::string> breaches_of_user_interface(const std::vector<SourceFile>& files);

/// No two folders of the product include each other, also by way of others. A stage's own folder and the
/// rooms in it count as one.
std::vector<std::string> breaches_of_folder_cycles(const std::vector<SourceFile>& files);

/// Public headers, and what they include of ours, name nothing but the standard library, Eigen and our own
/// headers; those of the table exist.
std::vector<std::string> breaches_of_public_headers(const std::vector<SourceFile>& files,
                                                    const std::set<std::string>& public_headers);

/// No folder is called util, utils, common, include or third_party.
std::vector<std::string> breaches_of_folder_names(const std::vector<std::string>& folders);

/// No file has more than 600 lines.
std::vector<std::string> breaches_of_length(const std::vector<SourceFile>& files);

/// No line of C++ is wider than 110 characters, raw strings aside (.clang-format sees to the rest).
std::vector<std::string> breaches_of_width(const std::vector<SourceFile>& files);

/// No function sets OpenCV's number of threads, which is the whole process's: other threads work in them. A
/// constant that is made before main() may (docs/adr/0339).
std::vector<std::string> breaches_of_opencv_threads(const std::vector<SourceFile>& files);

}  // namespace floatstage::architecture
