#pragma once

#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/matting_laplacian.h"

// Closed-form matting: A. Levin, D. Lischinski, Y. Weiss, "A Closed-Form Solution to Natural Image Matting",
// PAMI 2008.
namespace floatstage::matting {

struct ClosedFormOptions {
  LaplacianOptions laplacian;
  double constraint = 100;  ///< lambda of eq. 15: how hard known pixels are held; > 0
  double prior = 0;         ///< how hard every unknown pixel is pulled to `prior_opacity`; 0 … 1e3
  int most_unknown =
      400'000;  ///< pixels solved at once (about 0.8 GB); larger pictures are solved coarse to fine

  Result<void> check() const;
};

/// The opacity of every pixel from those that are known (eq. 15): minimises
///   a' L a + lambda sum over known (a - k)^2 + prior * sum over unknown w (a - p)^2
/// by a sparse Cholesky factor over the unknown pixels and the known ones that they touch; what lies deeper
/// in the known costs nothing. Where more than `most_unknown` are unknown, the picture is solved at half the
/// size first and carried up with refine_matte().
///
/// `picture`: 1 or 3 channels, at least 3x3. `trimap`: one channel of its size, 0 known background, 255 known
/// subject, everything else unknown. `prior_opacity`: empty, or of its size, what unknown pixels are held to
/// by `options.prior`; `prior_weight`: empty (1 everywhere) or 0 … 255. Returns one channel, 0 … 255.
/// Deterministic, one thread. Errors: InvalidArgument naming the size or option that does not fit, or a
/// trimap without anything known; Unsupported when memory does not suffice.
Result<Image> closed_form_matte(const Image& picture, const Image& trimap,
                                const ClosedFormOptions& options = {}, const Image& prior_opacity = {},
                                const Image& prior_weight = {});

/// A trimap around a matte: unknown within `margin` px of where it is soft (`soft_below` … `soft_above` of
/// 255) or crosses half opacity; 0 and 255 elsewhere.
struct TrimapOptions {
  int margin = 3;      ///< px
  int soft_from = 13;  ///< opacity from here on is not surely background …
  int soft_to = 242;   ///< … and up to here not surely subject
};
Image trimap_around(const Image& matte, const TrimapOptions& options = {});

/// Known pixels of a scribbled picture: where it differs from `picture`, as its first channel says (Levin's
/// files: white subject, black background). 128 elsewhere. InvalidArgument when the sizes or channel counts
/// differ, or nine pixels of ten become other colours: then it is another picture, or one coded anew.
Result<Image> trimap_from_scribbles(const Image& picture, const Image& scribbled);

struct RefineOptions {
  ClosedFormOptions solve;  ///< its `prior` is not used: `hold` is
  TrimapOptions band;       ///< in pixels of the matte that is refined
  double hold = 1e-4;  ///< prior of the coarse matte inside the band: settles what the colours leave open
};

/// How a key is refined: held much harder than a matte that was only carried, since a key has seen every
/// pixel. On clips with exact truth this is what makes closed form better than the key it starts from,
/// patterned clothes included.
RefineOptions key_refinement();

/// Closed form in the unknown band of a matte, and the way from a small matte to a large picture: the matte
/// is brought to the picture's size by the affine colour models of its own windows (He et al., "Guided Image
/// Filtering", 2013, eq. 16, at the small size), a band is laid around it and solved against the full
/// picture. `matte` has one channel and about the picture's shape; `keep` (empty, or one channel of the
/// picture's size): pixels that are not 128 are known there (scribbles, masks). A matte of all background or
/// all subject comes back as it is.
Result<Image> refine_matte(const Image& picture, const Image& matte, const RefineOptions& options = {},
                           const Image& keep = {});

}  // namespace floatstage::matting
