#include "studio/live/silhouette_findings.h"

#include <cmath>

#include "core/text.h"
#include "matting/doubt_picture.h"
#include "recon/mesh/mesh_silhouettes.h"
#include "recon/outline.h"
#include "recon/silhouette_contradiction.h"

namespace floatstage::studio {
namespace {

constexpr int kQualityStep = 4;  // rows of the pictures: tells nearly the same as all
constexpr int kTile = 320;       // px, of a picture's longer side
constexpr std::size_t kMostTiles = 12;

constexpr const char* kNoBody =
    "no body explains what the cameras see: their keys, their clocks or the calibration are off";

long percent(double share) { return std::lround(100 * share); }

std::string hint_of(const std::string& key) {
  if (key.empty()) return "";
  return key.starts_with("chroma") ? " (does the performer wear the cloth's colour?)"
                                   : " (does the performer wear the backdrop's colours?)";
}

}  // namespace

SilhouetteFindings::SilhouetteFindings(const Rig& rig, const std::string& key)
    : rig_(rig), hint_(hint_of(key)) {}

void SilhouetteFindings::add(const recon::SilhouetteVerdict& verdict,
                             std::vector<SilhouetteFinding>& found) const {
  const std::string& serial = rig_.cameras[static_cast<std::size_t>(verdict.camera)].serial;
  const bool lacks = verdict.lost >= verdict.gained;
  found.push_back(
      {text(serial, lacks ? " lacks" : " adds"),
       lacks ? text("camera '", serial, "' lacks ", percent(verdict.lost),
                    " % of what the others see: look at its light, its lens and what stands before it")
             : text("camera '", serial, "' shows ", percent(verdict.gained),
                    " % of subject that no other confirms: look at its backdrop and for what moved in it"),
       {verdict.camera}});
}

void SilhouetteFindings::add_contradiction(const std::string& why, std::vector<int> cameras,
                                           std::vector<SilhouetteFinding>& found) const {
  std::string who;
  for (const int c : cameras)
    who += text(who.empty() ? "" : ", ", "'", rig_.cameras[static_cast<std::size_t>(c)].serial, "'");
  found.push_back({"contradiction", text("cameras ", who, ": ", why), std::move(cameras)});
}

std::vector<SilhouetteFinding> SilhouetteFindings::of(std::span<const Silhouette> outlines) {
  std::vector<SilhouetteFinding> found;
  recon::HullOptions options;
  options.voting = recon::HullVoting::Auto;
  options.quality_step = kQualityStep;
  options.threads = 1;
  if (!recon::visual_hull(rig_, outlines, options, workspace_, hull_)) return found;
  mattes_.resize(outlines.size());
  for (std::size_t c = 0; c < outlines.size(); ++c) {
    const CameraModel& model = rig_.cameras[c].model;
    mattes_[c] = outlines[c].empty() ? Matte() : recon::filled(outlines[c], model.width, model.height);
  }
  const auto contradiction =
      recon::contradiction_between(recon::denials_of(rig_, mattes_, hull_, options, 0));
  std::vector<int> cameras;
  if (contradiction) {
    for (const auto& [serial, share] : contradiction->shares) cameras.push_back(camera_index(rig_, serial));
    add_contradiction(recon::describe(*contradiction, hint_), std::move(cameras), found);
  } else if (hull_.contradictory) {
    for (const recon::SilhouetteVerdict& verdict : hull_.verdicts) cameras.push_back(verdict.camera);
    add_contradiction(kNoBody, std::move(cameras), found);
  } else {
    for (const recon::SilhouetteVerdict& verdict : hull_.verdicts) add(verdict, found);
  }
  return found;
}

Image SilhouetteFindings::picture(const std::vector<int>& cameras, const std::vector<Image>& rgb) const {
  const recon::MeshSilhouettes hull(hull_.mesh);
  std::vector<Image> tiles;
  for (const int camera : cameras) {
    const auto c = static_cast<std::size_t>(camera);
    if (tiles.size() >= kMostTiles || c >= rgb.size() || rgb[c].empty() || mattes_[c].empty()) continue;
    tiles.push_back(matting::doubt_tile(rgb[c], mattes_[c], hull.of(rig_.cameras[c]), kTile));
  }
  return matting::contact_sheet(tiles);
}

}  // namespace floatstage::studio
