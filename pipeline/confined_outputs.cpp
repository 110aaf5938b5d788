#include "pipeline/confined_outputs.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>

#include "core/claim.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/confined_job.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kEndingSeconds = 10;

/// The hidden folders that outputs lie in until they are whole: one beside the outputs of each folder.
class Staging {
 public:
  Staging() = default;
  ~Staging() {
    std::error_code ignored;
    for (const auto& [folder, stage] : stages_) fs::remove_all(stage.folder, ignored);
  }
  Staging(const Staging&) = delete;
  Staging& operator=(const Staging&) = delete;

  Result<void> begin(const std::vector<fs::path>& outputs) {
    for (const fs::path& output : outputs) {
      if (output.empty()) continue;
      if (output.filename().empty() || output.filename() == "." || output.filename() == "..")
        return fail(ErrorCode::InvalidArgument, text("'", output.string(), "' is no name of a file"));
      outputs_.push_back(output);
      if (stages_.contains(output.parent_path())) continue;
      std::error_code error;
      if (const fs::path& folder = output.parent_path(); !folder.empty() && !fs::exists(folder, error))
        return fail(ErrorCode::NotFound, text("cannot write ", output.string(), ": ", std::strerror(ENOENT)));
      Result<Claim> claim = claim_temporary_folder(output, IfThere::Replace);
      if (!claim) return forward(claim);
      stages_[output.parent_path()] = {temporary_name(output), std::move(*claim)};
    }
    return {};
  }

  std::vector<fs::path> folders() const {
    std::vector<fs::path> out;
    for (const auto& [folder, stage] : stages_) out.push_back(stage.folder);
    return out;
  }

  fs::path place_of(const fs::path& output) const {
    return output.empty() ? output : stages_.at(output.parent_path()).folder / output.filename();
  }

  /// An error of the job in the words of who asked for it.
  Unexpected renamed(Error error) const {
    for (const fs::path& output : outputs_) {
      const std::string staged = place_of(output).string(), named = output.string();
      for (std::size_t at = 0; (at = error.message.find(staged, at)) != std::string::npos; at += named.size())
        error.message.replace(at, staged.size(), named);
    }
    return fail(error.code, std::move(error.message));
  }

  Result<void> publish() const {
    for (const fs::path& output : outputs_)
      if (Result<void> ok = put(place_of(output), output); !ok) return ok;
    return {};
  }

 private:
  struct Stage {
    fs::path folder;
    Claim claim;
  };

  // What is not there was not asked for. Whoever made it may have been taken over: neither links nor devices.
  static Result<void> put(const fs::path& from, const fs::path& to) {
    std::error_code error;
    const auto cannot = [&] {
      return fail(ErrorCode::Io, text("cannot write ", to.string(), ": ", error.message()));
    };
    const fs::file_status status = fs::symlink_status(from, error);
    if (!fs::exists(status)) return {};
    if (fs::is_regular_file(status)) {
      fs::rename(from, to, error);
      return error ? Result<void>(cannot()) : Result<void>();
    }
    if (!fs::is_directory(status))
      return fail(ErrorCode::BadData, text(to.string(), ": what was made for it is no file"));
    if (Result<void> ok = make_folder(to); !ok) return ok;
    for (fs::directory_iterator it(from, error), end; !error && it != end; it.increment(error))
      if (Result<void> ok = put(it->path(), to / it->path().filename()); !ok) return ok;
    return error ? Result<void>(cannot()) : Result<void>();
  }

  std::vector<fs::path> outputs_;
  std::map<fs::path, Stage> stages_;  // by the outputs' folder
};

/// A folder that is there at once, and away again when nothing was put into it.
class KeptFolder {
 public:
  KeptFolder() = default;
  ~KeptFolder() {
    std::error_code ignored;
    if (!made_.empty()) fs::remove(made_, ignored);  // an empty one only
  }
  KeptFolder(const KeptFolder&) = delete;
  KeptFolder& operator=(const KeptFolder&) = delete;

  Result<void> begin(const fs::path& folder) {
    std::error_code ignored;
    if (folder.empty() || fs::exists(folder, ignored)) return {};
    made_ = folder;
    return make_folder(folder);
  }

 private:
  fs::path made_;
};

}  // namespace

Result<void> make_confined(const ConfinedOutputs& made, Progress* progress,
                           const std::function<Result<void>(const PlaceOf&, Progress*)>& job) {
  Staging staging;
  KeptFolder kept;
  if (Result<void> ok = staging.begin(made.outputs); !ok) return ok;
  if (Result<void> ok = kept.begin(made.kept); !ok) return ok;
  Confinement limits{.what = made.what, .writable = staging.folders()};
  if (!made.kept.empty()) {
    limits.writable.push_back(made.kept);
    limits.ending_seconds = kEndingSeconds;  // to keep what it has
  }
  std::fflush(stdout);  // or the child would print it once more
  const Result<std::string> done =
      run_confined_bytes(limits, progress, [&](Progress* told) -> Result<std::string> {
        const Result<void> ok = job([&](const fs::path& output) { return staging.place_of(output); }, told);
        std::fflush(stdout);
        if (!ok) return forward(ok);
        return std::string();
      });
  if (!done) return staging.renamed(done.error());
  return staging.publish();
}

}  // namespace floatstage::pipeline
