// Method:  cubes that all but a few cameras agree on, where subject is left that no strict body explains
// Paper:   compare C. Hernández, F. Schmitt, R. Cipolla, "Silhouette coherence for camera calibration under
//          circular motion", 2007
// Differs: it asks who dissents, not how much all do; blocks in the place of pixels
// ADR:     0177

#include "recon/silhouette_audit.h"

#include <algorithm>
#include <cmath>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr int kMargin = 2;  // blocks around what is lost: a block is as uncertain as the cubes that found it
const double kBall = std::sqrt(3.0);

int count_of(const std::vector<std::uint8_t>& blocks) {
  return static_cast<int>(std::count(blocks.begin(), blocks.end(), 1));
}

/// Blocks as a picture of a camera's size.
Matte picture_of(const BlockPicture& blocks, const CameraModel& model, const std::vector<std::uint8_t>& set) {
  Image image(model.width, model.height, 1);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x)
      image.at(x, y)[0] = set[blocks.index(x / blocks.block, y / blocks.block)] != 0 ? 255 : 0;
  }
  return make_matte({}, image);
}

}  // namespace

/// Whether enough cameras see the cube and all but a few of them see subject there.
bool SilhouetteAudit::admit(const BlockPictures& pictures, double half, bool small, int most, int cameras,
                            Cube& cube) const {
  int agree = 0;
  cube.dissent = 0;
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    if (!pictures[c].known) continue;
    const auto answer = pictures.ask(c, cube.center, small ? half : kBall * half, small);
    agree += answer == BlockPictures::Answer::Subject;
    if (answer != BlockPictures::Answer::Background) continue;
    if (cube.dissent == most) return false;
    cube.cameras[static_cast<std::size_t>(cube.dissent++)] = static_cast<std::int16_t>(c);
  }
  return agree >= std::max(cameras, 2 * cube.dissent + 1);
}

void SilhouetteAudit::carve(const StageFinder& finder, int most, int cameras) {
  cubes_.assign(1, {finder.focus()});
  half_ = finder.searched();
  while (half_ > finder.half() && !cubes_.empty() && cubes_.size() <= StageFinder::kMostCubes) {
    half_ /= 2;
    const bool small = half_ * StageFinder::kSmall <= finder.searched();
    next_.clear();
    for (const Cube& cube : cubes_) {
      for (int octant = 0; octant < 8; ++octant) {
        Cube part{cube.center +
                  half_ * Vector3d(octant & 1 ? 1 : -1, octant & 2 ? 1 : -1, octant & 4 ? 1 : -1)};
        if (admit(finder.pictures(), half_, small, most, cameras, part)) next_.push_back(part);
      }
    }
    cubes_.swap(next_);
  }
}

/// Whether most of the cameras that show subject at the cube (two at least) have some there that is not
/// explained yet: what the strict body would gain without its dissenters explains a few silhouettes with too
/// much by chance. Where all dissenters are guilty already, two are enough.
bool SilhouetteAudit::explains(const BlockPictures& pictures, const Cube& cube) const {
  int agreeing = 0, lacking = 0;
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    int x0, y0, x1, y1;
    if (!pictures[c].known || !pictures.blocks_of(c, cube.center, half_, x0, y0, x1, y1)) continue;
    agreeing += pictures[c].count(x0, y0, x1, y1) > 0;
    lacking += pictures[c].count(sums_[c], x0, y0, x1, y1) > 0;
  }
  const bool known_guilty =
      std::all_of(cube.cameras.begin(), cube.cameras.begin() + cube.dissent,
                  [&](std::int16_t c) { return guilty_[static_cast<std::size_t>(c)] != 0; });
  return lacking >= 2 && (known_guilty || 2 * lacking > agreeing);
}

/// Whom the cubes with that many dissenters accuse.
void SilhouetteAudit::blame(const BlockPictures& pictures, int dissent) {
  sums_.resize(pictures.size());
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    if (pictures[c].known) pictures[c].sum_up(unexplained_[c], sums_[c]);
  }
  for (const Cube& cube : cubes_) {
    if (cube.dissent != dissent || !explains(pictures, cube)) continue;
    for (std::size_t c = 0; c < pictures.size(); ++c) {
      int x0, y0, x1, y1;
      if (!pictures[c].known || !pictures.blocks_of(c, cube.center, half_, x0, y0, x1, y1)) continue;
      const auto end = cube.cameras.begin() + dissent;
      const bool guilty = std::find(cube.cameras.begin(), end, static_cast<std::int16_t>(c)) != end;
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          const std::size_t at = pictures[c].index(x, y);
          if (guilty) {
            lost_[c][at] |= pictures[c].subject[at] == 0;
          } else {
            unexplained_[c][at] = 0;
          }
        }
      }
    }
  }
}

SilhouetteVerdict SilhouetteAudit::verdict(const BlockPictures& pictures, std::size_t camera) const {
  const BlockPicture& picture = pictures[camera];
  const double subject = count_of(picture.subject), lost = count_of(lost_[camera]);
  SilhouetteVerdict out;
  out.camera = static_cast<int>(camera);
  out.lost = lost / std::max(1.0, subject + lost);
  out.gained = count_of(unexplained_[camera]) / std::max(1.0, subject);
  return out;
}

std::vector<SilhouetteVerdict> SilhouetteAudit::audit(const Rig& rig, const HullInput& input,
                                                      const StageFinder& finder) {
  const BlockPictures& pictures = finder.pictures();
  std::vector<SilhouetteVerdict> found;
  unexplained_ = finder.unexplained();
  lost_.resize(pictures.size());
  bool doubt = false;
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    lost_[c].assign(pictures[c].known ? pictures[c].subject.size() : 0, 0);
    doubt |= pictures[c].known && verdict(pictures, c).gained > kAllowed;
  }
  if (!doubt) return found;
  const int most = std::min(kMostDissent, pictures.known() / 4);
  // As many as a body without dissent needs: fewer are often a few mattes with too much.
  const int cameras = std::min(StageFinder::cameras_of(pictures.known()), pictures.known() - 1);
  if (most > 0) carve(finder, most, cameras);
  guilty_.assign(pictures.size(), 0);
  for (const bool again : {false, true}) {
    for (int dissent = 1; dissent <= most; ++dissent) blame(pictures, dissent);
    for (std::size_t c = 0; c < pictures.size() && !again; ++c)
      guilty_[c] = pictures[c].known && verdict(pictures, c).lost > kAllowed;
  }
  for (std::size_t c = 0; c < pictures.size(); ++c) {
    if (!pictures[c].known || !input.knows(c)) continue;
    SilhouetteVerdict one = verdict(pictures, c);
    if (one.lost <= kAllowed && one.gained <= kAllowed) continue;
    one.lost_where = picture_of(pictures[c], rig.cameras[c].model, lost_[c]);
    one.gained_where = picture_of(pictures[c], rig.cameras[c].model, unexplained_[c]);
    one.block = pictures[c].block;
    found.push_back(std::move(one));
  }
  std::stable_sort(found.begin(), found.end(), [](const SilhouetteVerdict& a, const SilhouetteVerdict& b) {
    return std::max(a.lost, a.gained) > std::max(b.lost, b.gained);
  });
  return found;
}

Matte mended(const Matte& matte, const SilhouetteVerdict& verdict) {
  Image alpha = to_image(matte);
  const int reach = kMargin * verdict.block;
  for (int y = 0; y < alpha.height; y += verdict.block) {
    for (int x = 0; x < alpha.width; x += verdict.block) {
      if (verdict.lost_where.row(y)[x] == 0) continue;
      for (int v = std::max(0, y - reach); v < std::min(alpha.height, y + reach + verdict.block); ++v) {
        std::uint8_t* row = alpha.at(0, v);
        std::fill(row + std::max(0, x - reach), row + std::min(alpha.width, x + reach + verdict.block),
                  std::uint8_t{255});
      }
    }
  }
  return make_matte(matte.source, alpha);
}

}  // namespace floatstage::recon
