#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "pipeline/matte/camera_matting.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/matte/spectral_take.h"

namespace floatstage::pipeline {

struct EditedCameraOptions {
  std::filesystem::path take;
  std::string serial = {};
  std::string how = {};              ///< MatteTakeOptions::how; empty: as the mattes were made
  std::filesystem::path guide = {};  ///< likewise; used only with a way
  int threads = 0;                   ///< of preparing spectral components
  bool replace = false;              ///< allow_replacing()
};

/// How long work is watched. Called from the thread that works.
struct RemakeWatch {
  std::function<bool()> stopped = [] { return false; };
  std::function<void(const std::string& what, int done, int all)> progress = [](const std::string&, int,
                                                                                int) {};
  std::function<void(int frame)> made = [](int) {};  ///< a matte lies on disk under its name
};

/// One camera of a take whose mattes follow its edits: after each change only what the change concerns is
/// made again, and those mattes are, byte for byte, those that `floatstage matte` makes from the same
/// mattes/edits.json. Mattes that no edit concerns stay as they are: the verb may have cut them anew by what
/// all cameras see (MatteHealer).
///
/// It works on any take. Mattes of unknown origin are changed only when that is allowed: then their originals
/// lie in mattes/given/, where they are the key of their frames from then on.
///
/// While it works, mattes/made.json names the frames whose mattes are still those of before, so that whatever
/// happens `matte` (or another EditedCamera) goes on from there. Every file is whole at any time. Of the way
/// "consistent" mattes may differ from the verb's by a few pixels (consistent_take.h). Calls come from one
/// thread at a time; no other program works on the camera meanwhile.
class EditedCamera {
 public:
  /// Errors: those of TakeReader::open(); InvalidArgument for a camera or way that there is not; those of
  /// MatteStore::open() and load_matte_edits(). Quick: the key is made by the first remake().
  static Result<std::unique_ptr<EditedCamera>> open(const EditedCameraOptions& options);

  /// Makes the mattes that `edits` asks for. Returns the frames that changed, in order of their making.
  /// `edits` is what mattes/edits.json says of the camera (the caller wrote it). Errors: AlreadyExists when
  /// one of the mattes concerned is of unknown origin and may not be replaced; Cancelled, when it was
  /// stopped; those of CameraKey and VideoMatting; Io. After an error another call goes on. Photographs that
  /// cannot be matted are in failures() and have no matte.
  Result<std::vector<int>> remake(const CameraEdits& edits, const RemakeWatch& watch);
  const std::vector<std::string>& failures() const { return failures_; }
  /// Sentences on the strokes that change nothing in the mattes that the last remake() made.
  const std::vector<std::string>& idle() const { return idle_; }
  /// Likewise, on what strokes have changed in a frame and what could not be followed into its neighbour.
  const std::vector<std::string>& ended() const { return ended_; }
  /// Why mattes that lie there are not to be trusted, a sentence each, by frame.
  std::map<int, std::vector<std::string>> doubts() const;
  /// For each frame, whether what strokes say, in it or carried to it, makes its matte another one.
  std::vector<bool> guided() const;
  /// From now on mattes of unknown origin may be replaced; their originals are kept in mattes/given/.
  void allow_replacing() { options_.replace = true; }

  /// Frames whose mattes `edits` would change, missing ones and those left over from an interruption
  /// included.
  std::vector<bool> stale(const CameraEdits& edits) const;

  /// The matting components of a frame, whatever the method. Takes about a second where they are not kept.
  Result<matting::MattingComponents> components(int frame);
  /// matte_flicker() of a frame against the one before; absent without two mattes and photographs.
  Result<std::optional<double>> flicker(int frame);

  const std::string& how() const { return how_; }
  const CameraEdits& edits() const { return on_disk_; }  ///< as mattes/edits.json had them at open()
  capture::TakeReader& take() { return *take_; }

 private:
  EditedCamera(std::unique_ptr<capture::TakeReader> take, std::unique_ptr<MatteStore> store, int camera,
               EditedCameraOptions options);
  Result<void> settle();
  Result<void> make_key(const CameraEdits& edits, const RemakeWatch& watch);
  Result<bool> adopt(const std::vector<bool>& wanted);
  Result<void> begin(const CameraEdits& edits, const std::vector<bool>& stale);
  Result<std::vector<int>> make(const CameraEdits& edits, const std::vector<bool>& forced,
                                const std::vector<bool>& wanted, const RemakeWatch& watch);
  Result<std::vector<int>> follow(const CameraMatting& matting, std::vector<bool> forced,
                                  const RemakeWatch& watch);
  Result<std::vector<int>> spectral(const CameraMatting& matting, const std::vector<bool>& stale,
                                    const RemakeWatch& watch);
  Result<std::vector<int>> consistent(const CameraEdits& edits, const std::vector<bool>& stale,
                                      const RemakeWatch& watch);
  Result<bool> put(int frame, Result<Image> matte);
  std::vector<bool> changed_since(const CameraEdits& edits) const;
  CameraRecord& record() { return store_->camera(options_.serial); }
  const CameraRecord& record() const { return store_->record().at(options_.serial); }
  std::filesystem::path file(int frame) const { return take_->layout().matte(options_.serial, frame); }

  std::unique_ptr<capture::TakeReader> take_;
  std::unique_ptr<MatteStore> store_;
  int camera_;
  EditedCameraOptions options_;
  std::string how_;
  CameraEdits on_disk_;
  std::optional<CameraEdits> made_for_;  // of the mattes that are not stale
  std::optional<CameraKey> key_;
  CameraEdits key_edits_;  // that it was made for
  std::optional<SpectralTake> spectral_;
  bool prepared_ = false;
  bool strokes_only_ = false;  // nothing but strokes is another than in made_for_
  std::vector<std::string> failures_, idle_, ended_;
};

}  // namespace floatstage::pipeline
