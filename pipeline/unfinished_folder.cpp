#include "pipeline/unfinished_folder.h"

#include "core/file.h"
#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

UnfinishedFolder::UnfinishedFolder(const fs::path& out) : out_(out.lexically_normal()) {
  if (!out_.has_filename()) out_ = out_.parent_path();  // "T/"
  folder_ = temporary_name(out_);
}

UnfinishedFolder::~UnfinishedFolder() {
  if (!claim_ || published_) return;
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  if (out_claim_->made) fs::remove(out_, ignored);
}

Result<void> UnfinishedFolder::prepare() {
  if (out_.empty() || out_ == "." || out_ == "..")
    return fail(ErrorCode::InvalidArgument,
                text("'", out_.string(), "' is no name for a new folder; say --out <folder>"));
  Result<NewFolder> out = claim_new_folder(out_);
  if (!out) return forward(out);
  out_claim_ = std::move(*out);
  Result<Claim> folder = claim_temporary_folder(out_, IfThere::Replace);
  if (!folder && out_claim_->made) {
    std::error_code ignored;
    fs::remove(out_, ignored);
  }
  if (!folder) return forward(folder);
  claim_ = std::move(*folder);
  return {};
}

Result<void> UnfinishedFolder::publish() {
  std::error_code error;
  fs::rename(folder_, out_, error);  // over an empty folder, never over a full one
  if (error)
    return fail(ErrorCode::Io,
                text("cannot name the finished folder ", out_.string(), ": ", error.message()));
  published_ = true;
  return {};
}

}  // namespace floatstage::pipeline
