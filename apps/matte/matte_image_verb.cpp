#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "apps/matte/matte_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/text_options.h"
#include "apps/terminal/verb.h"
#include "core/png.h"
#include "core/text.h"
#include "detail/photo_file.h"
#include "matting/foreground.h"
#include "pipeline/confined_outputs.h"
#include "pipeline/json_report.h"
#include "pipeline/matte/matte_image.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct MatteImageArguments {
  std::string how = "auto";
  fs::path image, trimap, scribbles, out, foreground, json;
  std::vector<std::string> subject, background;
};

Image rgb_of(const Image& picture) {
  if (picture.channels == 3) return picture;
  Image out(picture.width, picture.height, 3);
  const std::size_t channels = static_cast<std::size_t>(picture.channels);
  for (std::size_t p = 0; p < out.pixels.size() / 3; ++p)
    for (std::size_t c = 0; c < 3; ++c)
      out.pixels[3 * p + c] = picture.pixels[p * channels + (channels == 1 ? 0 : c)];
  return out;
}

// One channel; of a picture with transparency, where it is transparent nothing is known.
Image grey_of(const Image& picture) {
  if (picture.channels == 1) return picture;
  Image out(picture.width, picture.height, 1);
  const std::size_t channels = static_cast<std::size_t>(picture.channels);
  for (std::size_t p = 0; p < out.pixels.size(); ++p) {
    const std::uint8_t* s = picture.pixels.data() + p * channels;
    out.pixels[p] = channels == 4 && s[3] < 128 ? 128 : s[1];
  }
  return out;
}

// "120,80": a click, as wide as a two-hundredth of the picture.
Result<MatteStroke> click_at(const std::string& place, MatteLabel label, const Image& picture) {
  const std::vector<std::string> parts = split_list(place);
  double at[2] = {};
  bool fits = parts.size() == 2;
  for (std::size_t i = 0; fits && i < 2; ++i) {
    const auto [end, error] = std::from_chars(parts[i].data(), parts[i].data() + parts[i].size(), at[i]);
    fits = error == std::errc() && end == parts[i].data() + parts[i].size();
  }
  if (!fits || !(at[0] >= 0 && at[0] < picture.width && at[1] >= 0 && at[1] < picture.height))
    return fail(ErrorCode::InvalidArgument,
                text("'", place, "' is no place in the picture of ", picture.width, "x", picture.height,
                     "; write a click as x,y in pixels"));
  return MatteStroke{label, std::max(2.0, std::max(picture.width, picture.height) / 200.0), {{at[0], at[1]}}};
}

// The subject's own colours with straight alpha.
Result<void> save_foreground(const Image& picture, const Image& matte, const fs::path& file) {
  Result<matting::Layers> layers = matting::estimate_foreground(picture, matte);
  if (!layers) return forward(layers);
  Image rgba(matte.width, matte.height, 4);
  for (std::size_t p = 0; p < matte.pixels.size(); ++p) {
    std::copy_n(layers->foreground.pixels.data() + 3 * p, 3, rgba.pixels.data() + 4 * p);
    rgba.pixels[4 * p + 3] = matte.pixels[p];
  }
  return save_png(rgba, file);
}

// How much of a picture its matte takes for the subject, 0 to 1.
double share_of(const Image& matte) {
  double sum = 0;
  for (const std::uint8_t alpha : matte.pixels) sum += alpha / 255.0;
  return matte.pixels.empty() ? 0 : sum / static_cast<double>(matte.pixels.size());
}

Result<void> make(const MatteImageArguments& given, const pipeline::PlaceOf& place_of) {
  Result<Image> picture = detail::load_photo(given.image);
  if (!picture) return forward(picture);
  pipeline::MatteImageOptions options{
      .how = given.how, .picture = std::move(*picture), .trimap = {}, .scribbled = {}};
  if (!given.trimap.empty()) {
    Result<Image> trimap = load_png(given.trimap);
    if (!trimap) return forward(trimap);
    options.trimap = grey_of(*trimap);
  }
  if (!given.scribbles.empty()) {
    Result<Image> scribbles = load_png(given.scribbles);
    if (!scribbles) return forward(scribbles);
    options.scribbled = rgb_of(*scribbles);
  }
  for (const auto& [places, label] :
       {std::pair{&given.subject, MatteLabel::Foreground}, {&given.background, MatteLabel::Background}})
    for (const std::string& place : *places) {
      Result<MatteStroke> click = click_at(place, label, options.picture);
      if (!click) return forward(click);
      options.clicks.push_back(std::move(*click));
    }
  Result<Image> matte = pipeline::matte_image(options);
  if (!matte) return fail(matte.error().code, text(given.image.string(), ": ", matte.error().message));
  if (Result<void> ok = save_png(*matte, place_of(given.out)); !ok) return ok;
  if (!given.foreground.empty())
    if (Result<void> ok = save_foreground(options.picture, *matte, place_of(given.foreground)); !ok)
      return ok;
  if (given.json.empty()) return {};
  return pipeline::save_json({{"matte", given.out.string()},
                              {"width", matte->width},
                              {"height", matte->height},
                              {"subject", share_of(*matte)}},
                             place_of(given.json));
}

Result<void> run_matte_image(const MatteImageArguments& given) {
  ProgressBar bar;
  return pipeline::make_confined(
      {.what = given.image.string(), .outputs = {given.out, given.foreground, given.json}}, &bar,
      [&](const pipeline::PlaceOf& place_of, pipeline::Progress*) { return make(given, place_of); });
}

}  // namespace

void add_matte_image(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<MatteImageArguments>();
  CLI::App* verb = add_verb(
      app, chosen, "matte-image", "The matte of one picture, from scribbles, a trimap, clicks, or its cloth",
      {"floatstage matte-image portrait.jpg --trimap trimap.png -o matte.png",
       "floatstage matte-image portrait.png --matte spectral --subject 120,80 --background 10,10 -o "
       "matte.png"});
  verb->add_option("image", options->image, "A photograph: PNG, JPEG or TIFF")->required();
  add_out(*verb, options->out, "Write the matte (PNG, one channel)")->required();
  verb->add_option("--matte", options->how,
                   "How the matte is made: auto, chroma, closed-form, pyramid or spectral")
      ->capture_default_str()
      ->type_name("HOW")
      ->check(one_of({"auto", "chroma", "closed-form", "pyramid", "spectral"}).description(""));
  verb->add_option("--scribbles", options->scribbles,
                   "The same picture with subject painted white and background black (PNG)")
      ->type_name("FILE");
  verb->add_option("--trimap", options->trimap, "Black background, white subject, grey unknown (PNG)")
      ->type_name("FILE");
  verb->add_option("--subject", options->subject, "A click on the subject, in pixels; may be given again")
      ->type_name("X,Y");
  verb->add_option("--background", options->background, "A click on the background")->type_name("X,Y");
  verb->add_option("--foreground", options->foreground,
                   "Write the subject's own colours with straight alpha (PNG)")
      ->type_name("FILE");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_matte_image(*options); }; });
}

}  // namespace floatstage::apps
