#include "pipeline/calibrate/new_session.h"

#include "core/text.h"
#include "pipeline/calibrate/session_draft.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

std::string commented(const std::vector<std::string>& sentences) {
  std::string out;
  for (const std::string& s : sentences) out += "#   " + s + "\n";
  return out;
}

}  // namespace

Result<NewSession> draft_session(const fs::path& folder, const fs::path& written_to,
                                 const NewSessionOptions& options, Progress* watch) {
  std::optional<calib::TargetDesign> given;
  if (!options.target.empty()) {
    const Result<calib::TargetDesign> parsed = calib::parse_target(options.target);
    if (!parsed) return forward(parsed);
    given = *parsed;
  }
  const Result<FolderSurvey> survey = survey_folder(folder);
  if (!survey) return forward(survey);
  SessionDraft d{*survey, options, written_to, {}, {}, {}, {}};
  if (survey->calibration)
    d.found(text("a calibration of ", survey->rig.rig.cameras.size(), " cameras, ",
                 survey->calibration_format, ": ", survey->calibration->path.string()));
  for (const std::string& sentence : survey->left_out) d.found(sentence + ", and was left out");
  const Result<std::optional<FoundBoard>> board = find_board(*survey, given, options.threads, watch);
  if (!board) return forward(board);
  if (*board) {
    if (Result<void> ok = draft_board(d, **board); !ok) return forward(ok);
  } else {
    const Result<bool> known = draft_known_scene(d);
    if (!known) return forward(known);
    if (!*known)
      if (Result<void> ok = draft_unknown_scene(d); !ok) return forward(ok);
  }
  d.out.toml = text("# Written by `floatstage calibrate new`.\n# Found:\n", commented(d.out.found),
                    "# Assumed:\n", d.out.assumed.empty() ? "#   nothing\n" : commented(d.out.assumed), "\n",
                    d.head, d.tables, d.cameras);
  return std::move(d.out);
}

}  // namespace floatstage::pipeline
