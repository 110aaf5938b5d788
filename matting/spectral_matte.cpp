#include "matting/spectral_matte.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "matting/guided_upsample.h"
#include "matting/picture_scale.h"
#include "matting/video/matte_propagation.h"

namespace floatstage::matting {
namespace {

bool same_size(const Image& a, const Image& b) { return a.width == b.width && a.height == b.height; }
bool marks(const MatteConstraint& o, std::size_t p) { return o.weight.empty() || o.weight.pixels[p] > 0; }

Result<void> check_said(const Image& picture, const MatteConstraint& said) {
  if (said.empty()) return {};
  if (said.opacity.channels != 1 || !same_size(said.opacity, picture) ||
      (!said.weight.empty() && (said.weight.channels != 1 || !same_size(said.weight, picture))))
    return fail(ErrorCode::InvalidArgument,
                text("what is known is ", said.opacity.width, "x", said.opacity.height,
                     ", but the picture is ", picture.width, "x", picture.height));
  for (std::size_t p = 0; p < said.opacity.pixels.size(); ++p)
    if (marks(said, p) && said.opacity.pixels[p] >= 128) return {};
  return fail(ErrorCode::InvalidArgument, "only background is marked; mark some of the subject");
}

}  // namespace

Result<Image> spectral_matte(const Image& picture, const MatteConstraint& said,
                             const VideoMattingOptions& options) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (Result<void> ok = check_said(picture, said); !ok) return forward(ok);
  const double shrink = std::min(
      1.0,
      std::sqrt(options.working_pixels / std::max(1.0, static_cast<double>(picture.width) * picture.height)));
  const int width = std::max(3, static_cast<int>(std::lround(picture.width * shrink))),
            height = std::max(3, static_cast<int>(std::lround(picture.height * shrink)));
  const Image small = scaled(picture, width, height);
  Result<EigenSolver> solver = EigenSolver::create(width, height, options.spectral);
  if (!solver) return forward(solver);
  const Result<EigenPairs> pairs = solver->solve(small);
  if (!pairs) return forward(pairs);
  const Result<MattingComponents> components = matting_components(*pairs, options.spectral);
  if (!components) return forward(components);
  Result<Selection> selection = fail(ErrorCode::InvalidArgument, "");
  if (said.empty()) {
    const auto laplacian = matting_laplacian(small, options.spectral.laplacian);
    if (!laplacian) return forward(laplacian);
    selection = guess_selection(*components, *laplacian);
  } else {
    selection = choose(*components, {scaled(said, width, height), {}, {}}, options);
  }
  if (!selection) return forward(selection);
  Result<Image> matte = guided_upsample(matte_of(*components, selection->chosen), picture);
  if (!matte || said.empty()) return matte;
  for (std::size_t p = 0; p < matte->pixels.size(); ++p)
    if (marks(said, p)) matte->pixels[p] = said.opacity.pixels[p];
  return matte;
}

}  // namespace floatstage::matting
