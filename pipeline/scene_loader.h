#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "capture/take.h"
#include "core/result.h"
#include "core/view.h"
#include "matting/keyers/keyer.h"
#include "pipeline/made_files.h"
#include "pipeline/matte_record.h"
#include "pipeline/mesh_record.h"

namespace floatstage::pipeline {

/// The mattes of one instant, whoever made them; empty where there is none. `hashes`, where it is given, gets
/// those of the bytes that were read. `cameras` (empty: all) says whose are decoded; the others' come back
/// empty. The first camera's error, whichever was met first.
Result<std::vector<Matte>> load_mattes(const capture::TakeReader& take, int frame,
                                       MatteHashes* hashes = nullptr, const std::vector<bool>& cameras = {});

/// The mattes of all subjects together, also of a take that labels were chosen from (chosen_take.h), of which
/// load_mattes() gives theirs alone.
Result<std::vector<Matte>> load_sums(const capture::TakeReader& take, int frame);

/// Photographs, mattes and mesh of instants of a processed take. What is the same for all of them (the
/// records of meshes and mattes, the keyers that take the cloth's cast off) is read or made once, and again
/// when its files have changed. Thread safe; the cameras of an instant are worked on by all cores.
class SceneLoader {
 public:
  /// `take` outlives the loader. With `suppress_spill` the cloth's cast is taken off the photographs of
  /// cameras that were keyed against a coloured cloth.
  SceneLoader(capture::TakeReader& take, bool suppress_spill)
      : take_(take), suppress_spill_(suppress_spill), keyers_(take.rig().cameras.size()) {}

  /// Which cameras a scene with this mesh is drawn from (render::drawn_from()); one entry a camera.
  using Choose = std::function<std::vector<bool>(const Mesh&)>;

  /// NotFound says which stage is missing and how to run it: no mesh, or one that is older than a matte of
  /// its instant. With `choose`, photographs and mattes of the chosen cameras alone are decoded, and `chosen`
  /// says so; of all where some camera has no picture or one of the chosen no matte.
  Result<SceneFrame> load(int frame, const Choose& choose = {}, bool* chosen = nullptr);

 private:
  template <class Record>
  struct Kept {
    FileMark file, journal;
    std::shared_ptr<const Record> record;
  };
  struct KeptKeyer {
    std::mutex making;
    std::string key;
    std::shared_ptr<const matting::Keyer> keyer;
  };
  template <class Record, class Load>
  Result<std::shared_ptr<const Record>> record(Kept<Record>& kept, const std::filesystem::path& file,
                                               const std::filesystem::path& journal, const Load& load);
  Result<std::shared_ptr<const matting::Keyer>> keyer(std::size_t camera, const std::string& key);
  Result<void> check_age(int frame, const MatteHashes& mattes);
  Result<void> take_spill_off(FrameSet& images);
  Result<FrameSet> photographs(int frame, std::vector<bool>& cameras);

  capture::TakeReader& take_;
  const bool suppress_spill_;
  std::mutex mutex_;  ///< of the records
  Kept<MeshRecord> meshes_;
  Kept<MatteRecord> mattes_;
  std::vector<KeptKeyer> keyers_;  ///< by camera
};

/// The take's rig with the colours that `calibrate color` found for it, where it did. BadData when those are
/// of other cameras.
Result<Rig> rig_with_colors(const capture::TakeReader& take);

}  // namespace floatstage::pipeline
