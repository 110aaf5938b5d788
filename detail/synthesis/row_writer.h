#pragma once

#include "core/image.h"
#include "core/result.h"

namespace floatstage::detail {

/// A picture that is written while it is made, so that it is nowhere whole. What was written without finish()
/// is no picture: a document or directory that names its parts is missing, or it is removed.
class RowWriter {
 public:
  virtual ~RowWriter() = default;
  /// The next rows, from the top: RGB, as wide as the picture. Io.
  virtual Result<void> add(const Image& rows) = 0;
  /// All rows are there. Io.
  virtual Result<void> finish() = 0;
};

}  // namespace floatstage::detail
