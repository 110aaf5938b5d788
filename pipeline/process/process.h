#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/chosen_take.h"
#include "pipeline/matte/heal_mattes.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/mesh_record.h"
#include "pipeline/process/silhouette_faults.h"
#include "pipeline/progress.h"
#include "pipeline/take_fields.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

struct ProcessOptions {
  std::filesystem::path take;
  std::optional<std::string> matte = {};        ///< MatteTakeOptions::how
  std::filesystem::path guide = {};             ///< MatteTakeOptions::guide
  std::optional<recon::HullOptions> hull = {};  ///< absent: as before, else exact with automatic voting
  std::vector<std::string> cameras = {};  ///< whose mattes are made, serials; empty: all. Meshes are made
                                          ///< from all mattes that there are
  std::vector<int> frames = {};           ///< empty: all
  int threads = 0;                        ///< 0: one per core
  bool gathered = false;  ///< a plan's items made meshes for this run, which speaks of them as of its own
  bool redo = false;      ///< make again what we made, with these options; others' files stay
  std::optional<bool> hide_added = {};  ///< MatteTakeOptions::hide_added
  bool fields = false;                  ///< make_fields(), too
  LabelChoice labels = {};       ///< whose meshes are made, in place of those of all; not with `fields`
  Progress* progress = nullptr;  ///< null: unwatched
};

/// What one stage did. made + kept + gaps + failures = items.
struct StageReport {
  int made = 0;                       ///< in this run
  int kept = 0;                       ///< there already
  int others = 0;                     ///< of unknown origin, among those that were kept
  int gaps = 0;                       ///< nothing to make: the camera has no photograph of that instant
  std::vector<std::string> failures;  ///< one sentence each
};

struct ProcessReport {
  int frames = 0, cameras = 0, empty_frames = 0;  ///< of those asked for; empty: nobody on stage
  StageReport mattes, meshes;
  std::optional<FieldReport> fields = {};  ///< where they were asked for
  std::vector<std::string> remarks = {};   ///< MatteReport::remarks
  int distrusted = 0;                      ///< MatteReport::distrusted
  std::vector<MatteDoubt> doubts = {};     ///< MatteReport::doubts, and of all meshes: contradiction_in()
  std::vector<HealedCamera> healed = {};   ///< mattes that were made again in this run, worst camera first
  // Of all meshes, also of those that were there:
  std::vector<SilhouetteFault> faults = {};     ///< what a matte lacks was overruled by the others
  std::vector<std::string> camera_doubts = {};  ///< where meshes were made: pipeline::camera_doubts()
  /// Of this run's frames, see pipeline::pose_doubts(); none where times are in doubt, as those of a turned
  /// camera look.
  std::vector<std::string> pose_doubts = {};
  int contradictory_frames = 0;  ///< hulls not to be trusted, see recon::HullReport::contradictory
  int poor_frames = 0;  ///< hulls that leave much of most silhouettes open, see recon::poorly_covered()
  int cut_frames = 0;   ///< hulls cut by the sides of the volume
  std::optional<CleanupCost> cleanup = {};  ///< what clean-up cost at most; absent: none was wished
  double seconds = 0;
};

/// The hull options that a run goes on with: those asked for, else those of the record, else the usual ones.
/// AlreadyExists when the record's meshes were made with others, without `redo`.
Result<recon::HullOptions> settle_hull_options(const capture::TakeReader& take, const ProcessOptions& options,
                                               const MeshRecord& record);
/// What of the options is about mattes.
MatteTakeOptions matte_options(const ProcessOptions& options);

/// Every offline stage on a take: mattes (matte_take()), then meshes. Does only what is missing or was made
/// from something else than what is there now: a mesh is made again when a matte of its instant has changed.
/// A file exists only when it is whole; one of unknown origin is used and never touched. Frames are
/// independent and run in parallel. One bad frame does not stop the others: it is reported, and the result is
/// an error only when nothing can go on (unwritable, disk full, other options than before without `redo`).
/// Mattes of ours that the others contradict are cut anew by the others' evidence (MatteHealer), unless a
/// camera's pictures show other instants; silhouettes
/// that they contradict still are named, with pictures in meshes/faults. Where labels were given, mattes are
/// divided among them anew when they have changed (label_take()).
Result<ProcessReport> process_take(const ProcessOptions& options);

}  // namespace floatstage::pipeline
