#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "render/zipmap/zipmap_needs.h"

namespace floatstage::render {

struct GlZipmapOptions {
  /// Bytes of video memory for root and patches, at most. What does not fit at once comes and goes.
  std::size_t budget = std::size_t{512} << 20;
  int most_layers = 0;  ///< of the array texture; 0: as many as driver and budget allow
};

/// Colours that say where what one sees comes from, laid over it.
struct ZipmapTints {
  float strength = 0;  ///< 0: the picture alone; 1: the colours alone
  Eigen::Vector3f root = Eigen::Vector3f::Zero(), rim = Eigen::Vector3f::Zero();  ///< rim: not opaque
  std::vector<Eigen::Vector3f> patches;  ///< one a patch; missing ones are black
};

struct ZipmapDrawing {
  /// Pixels from this column on show the root alone, as any texture; 0: all of them.
  int plain_from = std::numeric_limits<int>::max();
  /// Bytes that this picture may load, at least one level of one picture: what is missing is drawn as far as
  /// it is there, coarse levels and large parts of the view first. 0: all that it needs. A view that needs
  /// more pictures than there are layers loads all of it in any case.
  std::size_t most_loaded = 0;
  ZipmapTints tints = {};
};

/// What was drawn.
struct DrawnZipmap {
  int patches = 0, passes = 0;
  std::size_t loaded = 0;   ///< bytes, for this picture
  std::size_t waiting = 0;  ///< bytes that this view needs and that are not there
};

/// A zipmap drawn by OpenGL: the root in a texture, the patches' pictures in the layers of an array texture,
/// their matrices in a buffer; one pass over the picture, several where the view needs more pictures than
/// there are layers (M. Eisemann, "Error-Concealed Image-Based Rendering", 5.2.2). A picture has one layer
/// however many patches show it. It shows what Zipmap::draw() does. On the GL thread, while its context
/// lives.
class GlZipmap {
 public:
  /// InvalidArgument when the root and one layer are larger than the budget, or larger than a texture of this
  /// driver; Unsupported when the driver does not compile the shader.
  static Result<std::unique_ptr<GlZipmap>> make(std::shared_ptr<const Zipmap> zipmap,
                                                const GlZipmapOptions& options = {});
  virtual ~GlZipmap() = default;

  /// Draws into texture(), after loading what the view needs. InvalidArgument: a picture without pixels, or
  /// larger than a texture of this driver.
  virtual Result<DrawnZipmap> draw(const ZipmapView& view, const ZipmapDrawing& drawing = {}) = 0;
  /// The last picture: a texture of the view's size, rows top first; it is ours, and changes with the next.
  virtual unsigned texture() const = 0;
  /// The last picture, RGB.
  virtual Image read() const = 0;

  virtual std::size_t allocated() const = 0;  ///< bytes of video memory for root and patches
  virtual int layers() const = 0;             ///< pictures that are there at once, at most
  virtual const Zipmap& zipmap() const = 0;
};

}  // namespace floatstage::render
