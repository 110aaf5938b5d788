#include "pipeline/unfinished_folder.h"

#include <utility>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

UnfinishedFolder::UnfinishedFolder(fs::path out) : out_(std::move(out)), folder_(temporary_name(out_)) {}

UnfinishedFolder::UnfinishedFolder(UnfinishedFolder&& other) noexcept
    : out_(std::move(other.out_)),
      folder_(std::move(other.folder_)),
      out_claim_(std::exchange(other.out_claim_, std::nullopt)),
      claim_(std::exchange(other.claim_, std::nullopt)),
      published_(other.published_) {}

UnfinishedFolder::~UnfinishedFolder() {
  if (!claim_ || published_) return;
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  if (out_claim_->made) fs::remove(out_, ignored);
}

Result<UnfinishedFolder> UnfinishedFolder::begin(const fs::path& given) {
  fs::path out = given.lexically_normal();
  if (!out.has_filename()) out = out.parent_path();  // "T/"
  if (out.empty() || out == "." || out == "..")
    return fail(ErrorCode::InvalidArgument,
                text("'", given.string(), "' is no name for a new folder; say --out <folder>"));
  UnfinishedFolder take(std::move(out));
  Result<NewFolder> claimed = claim_new_folder(take.out_);
  if (!claimed) return forward(claimed);
  take.out_claim_ = std::move(*claimed);
  Result<Claim> folder = claim_temporary_folder(take.out_, IfThere::Replace);
  if (!folder && take.out_claim_->made) {
    std::error_code ignored;
    fs::remove(take.out_, ignored);
  }
  if (!folder) return forward(folder);
  take.claim_ = std::move(*folder);
  return take;
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
