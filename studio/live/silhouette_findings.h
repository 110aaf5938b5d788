#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/matte.h"
#include "core/rig.h"
#include "core/silhouette.h"
#include "recon/visual_hull.h"

namespace floatstage::studio {

/// What does not fit in the silhouettes of one instant.
struct SilhouetteFinding {
  std::string what;          ///< what two findings have in common that are the same, said of two instants
  std::string sentence;      ///< for people
  std::vector<int> cameras;  ///< that it names: places in the rig
};

/// One instant's silhouettes, judged as `process` judges mattes: a camera that lacks, or adds, more than a
/// twentieth against all others (HullVoting::Auto), and cameras that contradict one another
/// (recon::contradiction_between()). Keeps its memory; one thread at a time.
class SilhouetteFindings {
 public:
  /// `key`: what keys the cameras, for what it may have mistaken; or empty.
  SilhouetteFindings(const Rig& rig, const std::string& key);

  /// outlines[i] belongs to rig.cameras[i], an empty one says nothing. Nothing is found where they have no
  /// hull: the chain says that itself.
  std::vector<SilhouetteFinding> of(std::span<const Silhouette> outlines);

  /// The photographs of cameras (places in the rig), each with its silhouette of the last of() and, in light
  /// blue, that of the hull of all. `rgb`: one a camera, or empty. Empty where none of them is there.
  Image picture(const std::vector<int>& cameras, const std::vector<Image>& rgb) const;

 private:
  void add(const recon::SilhouetteVerdict& verdict, std::vector<SilhouetteFinding>& found) const;

  void add_contradiction(const std::string& why, std::vector<int> cameras,
                         std::vector<SilhouetteFinding>& found) const;

  const Rig rig_;
  const std::string hint_;
  std::vector<Matte> mattes_;
  recon::HullWorkspace workspace_;
  recon::HullReport hull_;
};

}  // namespace floatstage::studio
