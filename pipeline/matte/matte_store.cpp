#include "pipeline/matte/matte_store.h"

#include <filesystem>

#include <nlohmann/json.hpp>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

Result<std::unique_ptr<MatteStore>> MatteStore::open(const TakeLayout& layout) {
  std::unique_ptr<MatteStore> store(new MatteStore(layout));
  Result<MatteRecord> record = load_matte_record(layout);
  if (!record) return forward(record);
  store->record_ = std::move(*record);
  return store;
}

const CameraRecord* MatteStore::find(const std::string& serial) const {
  const auto found = record_.find(serial);
  return found == record_.end() ? nullptr : &found->second;
}

Result<MatteOrigin> MatteStore::origin(const std::string& serial, int frame) const {
  const Result<std::optional<std::string>> hash = hash_of(layout_.matte(serial, frame));
  if (!hash) return forward(hash);
  if (!*hash) return MatteOrigin::Missing;
  const CameraRecord* camera = find(serial);
  if (!camera) return MatteOrigin::Others;
  const auto known = camera->files.find(frame);
  return known != camera->files.end() && known->second == **hash ? MatteOrigin::Ours : MatteOrigin::Others;
}

Result<std::vector<MatteOrigin>> MatteStore::origins(const std::string& serial, int frames) const {
  std::vector<MatteOrigin> all(static_cast<std::size_t>(frames), MatteOrigin::Missing);
  for (const int frame : layout_.frames_with_mattes(serial)) {
    if (frame >= frames) break;
    const Result<MatteOrigin> one = origin(serial, frame);
    if (!one) return forward(one);
    all[static_cast<std::size_t>(frame)] = *one;
  }
  return all;
}

Result<bool> MatteStore::put(const std::string& serial, int frame, const Image& matte,
                             const std::optional<Healing>& healing) {
  const fs::path file = layout_.matte(serial, frame);
  const Result<std::string> bytes = encode_png_of_runs(matte);
  if (!bytes) return fail(bytes.error().code, text(file.string(), ": ", bytes.error().message));
  const std::string hash = capture::sha256(*bytes);
  const Result<std::optional<std::string>> before = hash_of(file);
  if (!before) return forward(before);
  // It is ours before it is there: what has no entry is somebody else's.
  if (Result<void> ok = journal_.add({{"camera", serial}, {"frame", frame}, {"sha256", hash}}); !ok)
    return forward(ok);
  if (Result<void> ok = write_file(file, *bytes); !ok) return forward(ok);
  const std::lock_guard lock(mutex_);
  CameraRecord& camera = record_[serial];
  camera.files[frame] = hash;
  camera.forget(frame);
  if (healing) camera.healed[frame] = *healing;
  return *before != hash;
}

bool MatteStore::healed_apart(const std::string& serial, int frame) {
  const std::lock_guard lock(mutex_);
  const CameraRecord& camera = record_[serial];
  return camera.healed.contains(frame) && !camera.guided.contains(frame) && camera.key != "cut";
}

void MatteStore::stands(const std::string& serial, int frame) {
  const std::lock_guard lock(mutex_);
  record_[serial].stale.erase(frame);
}

Result<void> MatteStore::adopt(const std::string& serial, int frame, const fs::path& file,
                               const std::string& hash) {
  if (Result<void> ok = journal_.add({{"camera", serial}, {"frame", frame}, {"sha256", hash}}); !ok)
    return ok;
  if (Result<void> ok = move_file(file, layout_.matte(serial, frame)); !ok) return ok;
  const std::lock_guard lock(mutex_);
  CameraRecord& camera = record_[serial];
  camera.files[frame] = hash;
  camera.forget(frame);
  return {};
}

Result<void> MatteStore::remove(const std::string& serial, int frame) {
  const fs::path file = layout_.matte(serial, frame);
  std::error_code error;
  fs::remove(file, error);
  if (error) return fail(ErrorCode::Io, text("cannot remove ", file.string(), ": ", error.message()));
  const std::lock_guard lock(mutex_);
  CameraRecord& camera = record_[serial];
  camera.files.erase(frame);
  camera.forget(frame);
  return {};
}

Result<void> MatteStore::save(const std::vector<std::string>& serials) {
  Result<MatteRecord> all = load_matte_record(layout_);
  if (!all) return forward(all);
  for (const std::string& serial : serials) (*all)[serial] = record_[serial];
  if (Result<void> ok = make_folder(layout_.mattes()); !ok) return ok;
  if (Result<void> ok = save_matte_record(*all, layout_); !ok) return ok;
  journal_.remove();
  return {};
}

}  // namespace floatstage::pipeline
