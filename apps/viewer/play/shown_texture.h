#pragma once

#include "core/image.h"

namespace floatstage::apps {

/// A picture of our own on the GPU, for the user interface to draw. GL thread only.
class ShownTexture {
 public:
  ShownTexture() = default;
  ShownTexture(const ShownTexture&) = delete;
  ShownTexture& operator=(const ShownTexture&) = delete;
  ~ShownTexture();

  void show(const Image& picture);     ///< copies it, RGB or RGBA; storage is kept while the size stays
  unsigned id() const { return id_; }  ///< 0 before the first picture

 private:
  unsigned id_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace floatstage::apps
