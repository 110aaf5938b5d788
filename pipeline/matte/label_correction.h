#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "matting/labels/label_palette.h"
#include "pipeline/matte/label_givens.h"
#include "recon/label_volume.h"

namespace floatstage::pipeline {

/// Voxels that somebody pointed at, by label - 1: those in front that words and masks of an instant lie on.
/// `mattes`: by camera, the sum. Masks are asked on a grid, small words whole.
std::vector<std::vector<std::size_t>> pointed_at(const recon::LabelVolume& volume,
                                                 const std::map<int, LabelsAllowed>& said,
                                                 const std::vector<Image>& mattes);

/// A word (a piece of pixels of which one label is said) in most of whose pixels its camera sees no voxel, so
/// that nobody can be meant by it.
struct NowhereWord {
  int label = 0;  ///< 1 …
  int camera = 0;
  Eigen::Vector2d at{0, 0};              ///< px, a pixel's middle in the middle of the word
  std::vector<Eigen::Vector2d> unmet{};  ///< likewise of some pixels that see none
  std::vector<int> denied_by{};          ///< cameras whose mattes have nobody there, where somebody has asked
};

/// All of them but specks of a mask: less than a twentieth of what is said of the label in that picture.
/// `volume` null: silhouettes bound nothing.
std::vector<NowhereWord> words_nowhere(const recon::LabelVolume* volume,
                                       const std::map<int, LabelsAllowed>& said,
                                       const std::vector<Image>& mattes);

/// What somebody said of an instant to which labels were carried, where it contradicts them.
struct LabelCorrection {
  std::vector<std::uint8_t> carried;           ///< a voxel: its label without what was said
  std::vector<std::uint8_t> anew;              ///< a voxel: not 0 where it is to be asked anew
  std::vector<std::vector<std::size_t>> seen;  ///< by label - 1: voxels in front that are said to be its
  std::uint32_t lost = 0;                      ///< bit l - 1: label l was carried to what is asked anew
  std::uint32_t said = 0;                      ///< likewise of labels that are said to be there
  bool none() const { return said == 0; }
};

/// Each word (a piece of pixels of which one label is said) is held against what its camera sees of
/// `carried`. Where most of it shows another label, the pieces of that label's volume that it lies on are
/// asked anew; where it shows its own, what it covers beside that is not. Where it shows no label, the piece
/// of nobody's volume that it lies on is asked anew.
LabelCorrection find_correction(const recon::LabelVolume& volume, const std::map<int, LabelsAllowed>& said,
                                const std::vector<Image>& mattes, std::vector<std::uint8_t> carried);

/// Bhattacharyya: labels whose colours are more alike are not told apart by them.
inline constexpr double kColorsAlike = 0.85;

/// Whether colours tell the labels apart that a correction is about: both are known, and no more alike than
/// `most` (LabelPalette::alike()). Not where nobody had it.
bool colors_tell(const LabelCorrection& correction, const matting::LabelPalette& palette, int labels,
                 double most);

}  // namespace floatstage::pipeline
