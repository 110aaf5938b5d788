#include "pipeline/matte/matte_image.h"

#include <algorithm>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/keyers/keyer.h"
#include "matting/method_selection.h"
#include "matting/pyramid_matte.h"
#include "matting/spectral_matte.h"

namespace floatstage::pipeline {
namespace {

Result<Image> by_chroma(const Image& picture) {
  Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_keyer("chroma", {picture});
  if (!keyer) return forward(keyer);
  Result<Matte> matte = (*keyer)->key(make_frame({}, picture));
  if (!matte) return forward(matte);
  return to_image(*matte);
}

Result<Image> trimap_of(const MatteImageOptions& options) {
  Image trimap = options.trimap;
  if (!trimap.empty() && (trimap.width != options.picture.width || trimap.height != options.picture.height))
    return fail(ErrorCode::InvalidArgument,
                text("the trimap is ", trimap.width, "x", trimap.height, " but the picture is ",
                     options.picture.width, "x", options.picture.height));
  if (!options.scribbled.empty()) {
    Result<Image> scribbles = matting::trimap_from_scribbles(options.picture, options.scribbled);
    if (!scribbles) return scribbles;
    if (trimap.empty()) trimap = Image(scribbles->width, scribbles->height, 1, 128);
    for (std::size_t p = 0; p < trimap.pixels.size(); ++p)
      if (scribbles->pixels[p] != 128) trimap.pixels[p] = scribbles->pixels[p];
  }
  if (!options.clicks.empty() && trimap.empty())
    trimap = Image(options.picture.width, options.picture.height, 1, 128);
  if (!options.clicks.empty()) paint_strokes(options.clicks, 1, trimap);
  return trimap;
}

// Everything that is 0 or 255 is known.
matting::MatteConstraint opinion_of(const Image& trimap) {
  matting::MatteConstraint said;
  if (trimap.empty()) return said;
  said = {trimap, trimap};
  for (std::uint8_t& w : said.weight.pixels) w = w == 0 || w == 255 ? 255 : 0;
  return said;
}

// What nobody marked would be missing from the whole matte.
Result<void> check_both_sides(const Image& trimap) {
  long subject = 0, background = 0;
  for (const std::uint8_t v : trimap.pixels) subject += v == 255, background += v == 0;
  const long known = subject + background, pixels = static_cast<long>(trimap.pixels.size());
  if (known == 0 || known == pixels || (subject > 0 && background > 0)) return {};
  return fail(ErrorCode::InvalidArgument, subject > 0
                                              ? "only subject is marked; mark some of the background, too"
                                              : "only background is marked; mark some of the subject, too");
}

bool all_of_one(const Image& trimap) {
  return !trimap.empty() && (trimap.pixels[0] == 0 || trimap.pixels[0] == 255) &&
         std::all_of(trimap.pixels.begin(), trimap.pixels.end(),
                     [&](int v) { return v == trimap.pixels[0]; });
}

}  // namespace

Result<Image> matte_image(const MatteImageOptions& options) {
  if (options.how != "auto" && options.how != "chroma" && options.how != "closed-form" &&
      options.how != "pyramid" && options.how != "spectral")
    return fail(ErrorCode::InvalidArgument,
                text("no method is called '", options.how,
                     "'; there are auto, chroma, closed-form, pyramid, spectral"));
  if (options.how == "chroma") return by_chroma(options.picture);
  Result<Image> trimap = trimap_of(options);
  if (!trimap) return trimap;
  const bool clicks_alone = !options.clicks.empty() && options.trimap.empty() && options.scribbled.empty();
  if (options.how == "spectral" || (options.how == "auto" && clicks_alone))
    return all_of_one(*trimap) ? trimap : matting::spectral_matte(options.picture, opinion_of(*trimap));
  if (!trimap->empty()) {
    if (Result<void> ok = check_both_sides(*trimap); !ok) return forward(ok);
    return options.how == "closed-form" ? matting::closed_form_matte(options.picture, *trimap)
                                        : matting::pyramid_matte(options.picture, *trimap);
  }
  if (options.how == "closed-form" || options.how == "pyramid")
    return fail(ErrorCode::InvalidArgument,
                text(options.how, " matting of one picture needs --trimap, --scribbles or clicks"));
  Result<Image> key = by_chroma(options.picture);
  if (!key)
    return fail(key.error().code,
                text(key.error().message,
                     "; without cloth, mark subject and background with --scribbles, --trimap or --subject"));
  Result<Image> refined = matting::refine_matte(options.picture, *key, matting::key_refinement());
  if (!refined) return refined;
  const std::vector<double> residuals = matting::composite_residuals(options.picture, {*key, *refined});
  return residuals[1] < residuals[0] ? refined : key;
}

}  // namespace floatstage::pipeline
