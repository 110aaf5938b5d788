#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "matting/labels/label_palette.h"

namespace floatstage::matting {

/// One picture whose subject is several people: who is to be told apart, and what is known.
struct LabelSplit {
  const Image& picture;  ///< RGB
  const Image& matte;    ///< one channel: all of them together
  const Image& hint;     ///< of each pixel who is probably seen there, 1 … `labels`; 0: not known
  /// Of each label where it is, seen or behind others: what `hint` says of a pixel may be wrong in favour of
  /// labels that are there, too, the more the nearer it is to the edge of the one in front.
  const std::vector<Image>& where;
  double slack = 3;  ///< px by which edges in those are off, as a rule
  int labels = 2;    ///< 1 to 31
  /// Of each pixel, which labels may be there: bit l - 1 for label l. Empty, or 0: any.
  const std::vector<std::uint32_t>& may;
  const LabelPalette& palette;
  /// A picture of the same camera shortly before or after, and its labels, to learn colours of each place
  /// from; null: none.
  const Image *near_picture = nullptr, *near_labels = nullptr;
};

struct LabelSplitOptions {
  double color = 1;    ///< how much colours of the place count
  double palette = 1;  ///< how much those of a label anywhere count
  double smooth = 2;   ///< how much edges cost
};

/// The label of every pixel with any opacity, 0 of the others: the cut of one energy of the distance to the
/// hint's edges, colours and contrast. Deterministic; one thread.
Image split_labels(const LabelSplit& split, const LabelSplitOptions& options = {});

/// The matte of each label from that of all: they share its opacity, so that they add up to it exactly; along
/// an edge between two labels by how many of the nine pixels around bear each.
std::vector<Image> share_matte(const Image& matte, const Image& labels, int count);

}  // namespace floatstage::matting
