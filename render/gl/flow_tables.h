#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/flow.h"
#include "render/gl/gl_objects.h"

namespace floatstage::render {

/// A field that is asked for: which pictures, and which field leads back (-1: none).
struct WantedField {
  FlowPair pair;
  int back = -1;
  bool asked = true;  ///< otherwise it is zero
};

/// What all kernels of the flow know of pictures and fields (shaders/flow.glsl has the twin).
class FlowTables {
 public:
  static constexpr int kMostPictures = 8, kMostFields = 64;

  /// At most kMostFields, between pictures below kMostPictures. Stays bound.
  void write(std::span<const WantedField> fields);
  int pictures() const { return pictures_; }
  int fields() const { return fields_; }
  int asked() const { return asked_; }
  /// The most fields that look from one picture.
  int from_one() const { return from_one_; }

 private:
  struct Block {
    std::array<std::array<int, 4>, kMostFields> fields;
    std::array<int, 8 * kMostPictures> from;
  };
  gl::Buffer buffer_;
  std::size_t capacity_ = 0;
  int pictures_ = 0, fields_ = 0, asked_ = 0, from_one_ = 0;
};

}  // namespace floatstage::render
