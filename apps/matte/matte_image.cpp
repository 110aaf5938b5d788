#include "apps/matte/matte_image.h"

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/consistency.h"
#include "matting/keyer.h"

namespace floatstage {
namespace {

Result<Image> by_chroma(const Image& picture) {
  Result<std::unique_ptr<Keyer>> keyer = make_keyer("chroma", {picture});
  if (!keyer) return forward(keyer);
  Result<Matte> matte = (*keyer)->key(make_frame({}, picture));
  if (!matte) return forward(matte);
  return to_image(*matte);
}

Result<Image> trimap_of(const MatteImageOptions& options) {
  Image trimap = options.trimap;
  if (!trimap.empty() && (trimap.width != options.picture.width || trimap.height != options.picture.height))
    return fail(ErrorCode::InvalidArgument, text("the trimap is ", trimap.width, "x", trimap.height, " but the picture is ", options.picture.width, "x", options.picture.height));
  if (options.scribbled.empty()) return trimap;
  Result<Image> scribbles = trimap_from_scribbles(options.picture, options.scribbled);
  if (!scribbles || trimap.empty()) return scribbles;
  for (std::size_t p = 0; p < trimap.pixels.size(); ++p)
    if (scribbles->pixels[p] != 128) trimap.pixels[p] = scribbles->pixels[p];
  return trimap;
}

}  // namespace

Result<Image> matte_image(const MatteImageOptions& options) {
  if (options.method != "auto" && options.method != "chroma" && options.method != "closed-form")
    return fail(ErrorCode::InvalidArgument, text("no method is called '", options.method, "'; there are auto, chroma, closed-form"));
  if (options.method == "chroma") return by_chroma(options.picture);
  Result<Image> trimap = trimap_of(options);
  if (!trimap) return trimap;
  if (!trimap->empty()) return closed_form_matte(options.picture, *trimap);
  if (options.method == "closed-form") return fail(ErrorCode::InvalidArgument, "closed-form matting of one picture needs --trimap or --scribbles");
  Result<Image> key = by_chroma(options.picture);
  if (!key)
    return fail(key.error().code, text(key.error().message, "; without cloth, mark subject and background with --scribbles or --trimap"));
  Result<Image> refined = refine_matte(options.picture, *key, key_refinement());
  if (!refined) return refined;
  const std::vector<double> residuals = composite_residuals(options.picture, {*key, *refined});
  return residuals[1] < residuals[0] ? refined : key;
}

}  // namespace floatstage
