#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/matte/doubt_pictures.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// A camera whose silhouettes the others contradict.
struct SilhouetteFault {
  std::string serial;
  int frames = 0;                 ///< in so many
  int worst = 0;                  ///< frame
  double lost = 0, gained = 0;    ///< there, see recon::SilhouetteVerdict
  std::filesystem::path picture;  ///< evidence_picture() of that frame; empty when there is no photograph
};

/// "camera 'x' lacks 62 % of what the others see in frame 3 (7 frames in all): PICTURE"
std::string sentence(const SilhouetteFault& fault);

/// The photograph, dark where the matte has no subject, red where the others see subject that the matte
/// lacks, blue where the matte has subject that no other confirms. `rgb` and the matte are of one size.
Image evidence_picture(const Image& rgb, const Matte& matte, const recon::SilhouetteVerdict& verdict);

/// Keeps, of frames that are made in parallel, each camera's worst verdict, to show it. Any thread.
class EvidenceCollector {
 public:
  void note(int frame, const recon::HullReport& hull, const std::vector<Matte>& mattes);
  /// A picture a camera, <serial>-<frame>.png, in `folder`, which is made if there is anything to show. Each
  /// is known there (DoubtPictures).
  Result<void> save(capture::TakeReader& take, const std::filesystem::path& folder) const;

 private:
  struct Worst {
    int frame = 0;
    recon::SilhouetteVerdict verdict;
    Matte matte;
  };
  std::mutex mutex_;
  std::vector<std::optional<Worst>> cameras_;
};

/// What clean-up cost the meshes of a take.
struct CleanupCost {
  int meshes = 0, most_triangles = 0;  ///< that were cleaned; of the largest
  double iou_loss = 0;                 ///< the most of any silhouette's IoU
  int frame = 0;                       ///< there
  std::string serial;
};

/// "clean-up left up to 5000 triangles a mesh; silhouettes' IoU fell by up to 0.0208 (camera 'x', frame 3)"
std::string sentence(const CleanupCost& cost);

/// What the hulls of a take, made now or before, say about themselves: read from the record of
/// meshes/hull.json.
struct HullDoubts {
  std::vector<SilhouetteFault> faults;  ///< worst first
  int contradictory = 0;                ///< frames, see recon::HullReport::contradictory
  int cut = 0;                          ///< frames, see recon::HullReport::cut
  int poor = 0;                         ///< frames, see recon::poorly_covered()
  std::optional<CleanupCost> cleanup;   ///< absent where nothing was cleaned
};

/// A frame's part of it: {"<serial>": {"lost", "gained"}}.
nlohmann::json silhouettes_json(const Rig& rig, const std::vector<recon::SilhouetteVerdict>& verdicts);
/// Likewise: {"triangles": [before, after], "iou_loss", "camera"}, the worst camera's.
nlohmann::json cleanup_json(const Rig& rig, const recon::MeshCleanupReport& cleanup);
/// `frames`: MeshRecord::reports, `pictures`: where EvidenceCollector saved them. What is not there says
/// nothing.
HullDoubts doubts_in(const std::map<int, nlohmann::json>& frames, const std::filesystem::path& pictures);

/// What a picture of a camera's fault is called, and what is known of it.
std::string picture_name(const std::string& serial, int frame);
DoubtPicture picture_of_fault(const std::string& serial, int frame);
/// Pictures of ours that show none of these faults go. Io.
Result<void> keep_pictures(const std::vector<SilhouetteFault>& faults, const std::filesystem::path& folder);

}  // namespace floatstage::pipeline
