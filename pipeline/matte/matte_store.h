#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "pipeline/made_files.h"
#include "pipeline/matte_record.h"

namespace floatstage::pipeline {

/// Where a matte comes from, by the bytes of its file.
enum class MatteOrigin {
  Missing,
  Ours,    ///< the record has these bytes
  Others,  ///< of unknown origin: used as it is, and never touched
};

/// A take's mattes/ and the record of what was made in it: the one way by which the program writes mattes.
/// put(), adopt(), remove(), healed_apart() and stands() are thread safe, the rest is not.
class MatteStore {
 public:
  /// Errors: those of load_matte_record().
  static Result<std::unique_ptr<MatteStore>> open(const TakeLayout& layout);

  const MatteRecord& record() const { return record_; }
  /// Null when nothing was made for the camera.
  const CameraRecord* find(const std::string& serial) const;
  CameraRecord& camera(const std::string& serial) { return record_[serial]; }
  const TakeLayout& layout() const { return layout_; }

  Result<MatteOrigin> origin(const std::string& serial, int frame) const;
  /// Of all frames of a camera.
  Result<std::vector<MatteOrigin>> origins(const std::string& serial, int frames) const;

  /// Puts a matte into its place, whole or not at all, whatever lay there. Whether there are other bytes now.
  /// `healing`: what the record says of it, if it was made by the others' evidence.
  Result<bool> put(const std::string& serial, int frame, const Image& matte,
                   const std::optional<Healing>& healing = {});
  /// Whether the others' evidence made a frame's matte, and strokes had nothing to do with it.
  bool healed_apart(const std::string& serial, int frame);
  /// The matte that lies there is as it would be made now.
  void stands(const std::string& serial, int frame);
  /// Puts a matte into its place that was made elsewhere: `file`, which is gone afterwards, has this hash.
  Result<void> adopt(const std::string& serial, int frame, const std::filesystem::path& file,
                     const std::string& hash);
  /// There is no matte of this frame; none is no error. Only of ours.
  Result<void> remove(const std::string& serial, int frame);

  /// Writes what the record says of these cameras; of others the file stays as it is.
  Result<void> save(const std::vector<std::string>& serials);

 private:
  explicit MatteStore(const TakeLayout& layout) : layout_(layout), journal_(layout.mattes_journal()) {}

  TakeLayout layout_;
  MatteRecord record_;
  Journal journal_;
  std::mutex mutex_;
};

}  // namespace floatstage::pipeline
