#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/matte/consistent.h"
#include "pipeline/matte/heal_mattes.h"
#include "pipeline/progress.h"
#include "recon/silhouette_agreement.h"

namespace floatstage::pipeline {

struct MatteTakeOptions {
  std::filesystem::path take;
  /// One of matte_methods(), a keyer perhaps with its parameter. Absent: as each camera's mattes were made
  /// before; of a new one as the others, where they agree; "given" where somebody put mattes into the take;
  /// else "auto".
  std::optional<std::string> how = {};
  std::filesystem::path guide = {};       ///< others' mattes to start from: <serial>/<frame>.png; empty: none
  std::vector<std::string> cameras = {};  ///< serials; empty: all
  std::vector<int> frames = {};           ///< empty: all
  /// Of a job that several runs share, each with frames of its own: all frames of the job, in order. Where
  /// mattes of a camera depend on one another, the run that has the first makes them all, the others none.
  std::vector<int> of_frames = {};
  /// Whether `auto` makes new mattes by what all cameras say at once; absent: it finds out.
  std::optional<bool> together = {};
  int threads = 0;    ///< 0: one per core
  bool redo = false;  ///< make again what we made, whatever the way; others' files stay
  /// Of all cameras: mattes of ours that the others contradict are made anew by heal_take(). Who makes hulls
  /// of them afterwards does it then.
  bool heal = false;
  bool check = true;    ///< flicker, and silhouettes against the others' hull
  int hull_frames = 8;  ///< instants, spread over the frames, at which silhouettes are checked
  /// What a camera or a converter added to pictures: see settle_added(). Not for matte_take() of a reader.
  std::optional<bool> hide_added = {};
  Progress* progress = nullptr;  ///< null: unwatched
};

struct CameraMattes {
  std::string serial;
  std::string key;     ///< what first told the subject: "chroma:#2f7a45", "plate:6", "guide", "given"
  std::string method;  ///< what auto chose, or what was asked for
  int made = 0, kept = 0, gaps = 0;      ///< of the frames asked for
  int others = 0;                        ///< of unknown origin, among those that were kept
  int keyframes = 0, clicks = 0;         ///< of a person; scribbles count as clicks
  double flicker = 0;                    ///< mean |opacity - that of the frame before| over frames in a row
  std::optional<double> hull_agreement;  ///< mean IoU with the hull of the others
  std::optional<ConsistentView> consistent;  ///< means over the instants, of the method of that name
  std::vector<std::string>
      idle;  ///< strokes that change nothing in the mattes that were made, a sentence each
  std::vector<std::string> failures;  ///< one sentence each, in the order of the frames
};

/// Mattes that are not to be trusted, of cameras for which the same is wrong.
struct MatteDoubt {
  std::string why;  ///< and what to do
  std::vector<std::string> cameras;
  int frames = 0;                 ///< in so many
  int worst = 0;                  ///< frame
  std::filesystem::path picture;  ///< that frame of those cameras with their mattes drawn in; empty: none
};

/// "cameras 'a', 'b', frame 3 (7 frames in all): WHY: PICTURE"
std::string sentence(const MatteDoubt& doubt);
/// Where their pictures lie.
std::filesystem::path doubts_folder(const TakeLayout& layout);

struct MatteReport {
  std::vector<CameraMattes> cameras;
  std::vector<recon::SilhouetteAgreement> worst;  ///< least agreement first
  std::vector<std::string> remarks;               ///< what may be wrong, with frames and cameras
  int distrusted = 0;                             ///< likewise: instants whose mattes are probably wrong
  std::vector<MatteDoubt> doubts;    ///< of the frames asked for, made now or before; most cameras first
  std::vector<HealedCamera> healed;  ///< in this run, worst camera first
  std::vector<std::string>
      camera_doubts;  ///< with `heal`: see pipeline::camera_doubts(); then none is healed
  int made = 0;
  double seconds = 0;            ///< of making mattes, the hull check left out
  double seconds_per_frame = 0;  ///< of wall time, a photograph made in this run; 0 when none was
};

/// Mattes of a take's cameras, each written to mattes/<serial>/<frame>.png when it is finished, and recorded
/// in mattes/made.json: the one maker behind `process`, `matte` and, camera by camera, the editor
/// (edited_camera.h).
///
/// What is there is kept, so a run that was interrupted goes on; made again are those of ours whose edits or
/// inputs (plates, guide) changed, and with `redo` all of ours. A matte of unknown origin is used as it is
/// and never touched. mattes/edits.json is replayed: masks outrank everything, a click chooses among a key's
/// separate parts, which are then followed from frame to frame, both ways. One bad photograph does not stop
/// the others. What cannot be trusted is named, with pictures in mattes/doubts. Memory: some photographs a
/// thread, and about 400 MB while a plate is learnt.
///
/// Errors, when nothing can go on: those of TakeReader::open(); InvalidArgument for a way, camera or frame
/// that there is not; AlreadyExists when ours were made another way, without `redo`; NotFound or Unsupported
/// when a camera has no key; Io (disk full: what was finished stays); Cancelled.
Result<MatteReport> matte_take(const MatteTakeOptions& options);
/// Likewise, in an open take; `options.take` is ignored.
Result<MatteReport> matte_take(capture::TakeReader& take, const MatteTakeOptions& options);

}  // namespace floatstage::pipeline
