#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <variant>
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

/// The part of one camera's photograph, and of its matte, in which what is drawn lies.
struct PhotographPart {
  int camera = -1;   ///< index into Rig::cameras
  PixelBox box;      ///< px, where in the photograph
  Image photograph;  ///< RGB
  Image matte;       ///< 1 channel, same size
};

/// What some views of an instant are drawn from.
struct SceneParts {
  Mesh mesh;
  std::vector<PhotographPart> photographs;  ///< in the rig's order
};

/// As much of an instant as there is to draw.
using DrawnScene = std::variant<SceneFrame, SceneParts>;

/// Photographs, mattes and mesh of instants of a processed take. What is the same for all of them (the
/// records of meshes and mattes, the keyers that take the cloth's cast off) is read or made once, and again
/// when its files have changed. Thread safe; the cameras of an instant are worked on by all cores.
class SceneLoader {
 public:
  /// `take` outlives the loader. With `suppress_spill` the cloth's cast is taken off the photographs of
  /// cameras that were keyed against a coloured cloth.
  SceneLoader(capture::TakeReader& take, bool suppress_spill)
      : take_(take), suppress_spill_(suppress_spill), keyers_(take.rig().cameras.size()) {}

  /// NotFound says which stage is missing and how to run it: no mesh, or one that is older than a matte of
  /// its instant.
  Result<SceneFrame> load(int frame);

  /// Which parts of each camera's photograph a scene with this mesh is drawn from (render/drawn_from.h), none
  /// where it does not need it; one entry a camera.
  using Choose = std::function<std::vector<std::vector<PixelBox>>(const Mesh&)>;
  /// The chosen parts alone, and no more is decoded for them than has to be (TakeReader::part()): around them
  /// a photograph may be anything. The whole scene where some camera has no picture.
  /// Errors as above.
  Result<DrawnScene> load_parts(int frame, const Choose& choose);

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
  Result<Mesh> mesh(int frame) const;
  Result<std::shared_ptr<const MatteRecord>> spill();
  bool has_spill(const std::shared_ptr<const MatteRecord>& made, std::size_t camera) const;
  Result<Image> clean(const MatteRecord& made, std::size_t camera, const Frame& frame);
  Result<void> take_spill_off(FrameSet& images);
  bool all_have_pictures(int frame) const;
  Result<PhotographPart> part(int frame, std::size_t camera, std::vector<PixelBox> boxes,
                              const std::shared_ptr<const MatteRecord>& made);

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
