#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "pipeline/reproduce/comparison.h"

namespace floatstage::pipeline {

/// A labelled picture of a sheet.
struct SheetCell {
  std::string name;
  Image picture;  ///< RGB
};
using SheetRow = std::vector<SheetCell>;

/// Rows of pictures below one another, each with its name printed into it.
Image sheet_of(const std::vector<SheetRow>& rows);

struct PictureWindow {
  int x = 0, y = 0, width = 0, height = 0;  ///< px
};

/// What a mask holds, and some pixels around it.
PictureWindow window_about(const Image& mask);
/// The square of `side` px, all of it in the mask as far as it can be, in which a picture differs most from
/// the truth.
PictureWindow worst_window(const Image& picture, const Image& truth, const Image& mask, int side);
/// A window of a picture, every pixel `zoom` times as wide and high.
Image cut(const Image& picture, const PictureWindow& window, int zoom);

/// Two rows of a compared view: truth and the methods' pictures, and below them close-ups of where
/// `worst_of` is worst.
std::vector<SheetRow> rows_of(const ComparedView& view, const std::vector<std::string>& methods,
                              const std::string& worst_of);

}  // namespace floatstage::pipeline
