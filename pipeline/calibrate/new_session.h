#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// What a new session is told beside its folder. Everything may be left as it is.
struct NewSessionOptions {
  std::string target;  ///< the board's line; empty: a file that describes it, else what pictures show
  std::optional<double> square;    ///< metres: side of the board's squares, where nothing else says it
  std::optional<double> distance;  ///< metres between the first two cameras, of scenes without a scale
  bool alone = false;              ///< stills of a board were taken by each camera for itself
  bool at_once = false;            ///< or at the same instants by all
  /// Answers a question (metres) or does not; null: nobody is asked, and what is assumed is said.
  std::function<std::optional<double>(const std::string& question)> ask = nullptr;
  int threads = 0;
};

/// A session's text that load_session() reads, and why it says what it says.
struct NewSession {
  std::string toml;                  ///< the sentences stand in it, too
  std::vector<std::string> found;    ///< what lies there, a sentence each
  std::vector<std::string> assumed;  ///< what nobody said, and why it is likely
  std::size_t cameras = 0;
};

/// Looks at what lies in a folder (boards, videos, EXIF, calibrations of other programs) and drafts a session
/// of it, to be written into `written_to` (which its paths are relative to). NotFound when there is nothing
/// to calibrate with; BadData says what is missing and which option gives it; errors of pictures name their
/// file.
Result<NewSession> draft_session(const std::filesystem::path& folder, const std::filesystem::path& written_to,
                                 const NewSessionOptions& options, Progress* watch = nullptr);

}  // namespace floatstage::pipeline
