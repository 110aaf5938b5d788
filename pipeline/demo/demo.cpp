#include "pipeline/demo/demo.h"

#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/film.h"
#include "pipeline/json_report.h"
#include "pipeline/orbit.h"
#include "pipeline/picture_sink.h"
#include "pipeline/process/process.h"
#include "pipeline/subject.h"
#include "render/back_end.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

const std::vector<std::string> kMethods = {"linear", "floating"};
constexpr const char* kProducts[] = {"take", "freeview.mp4", "compare.mp4", "report.json"};

// Only what a demo makes may stand in the folder; that is made again.
Result<void> clear_earlier_demo(const fs::path& out) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(out, error)) {
    const fs::path name = entry.path().filename();
    const bool ours =
        std::any_of(std::begin(kProducts), std::end(kProducts), [&](const char* p) { return name == p; });
    if (!ours)
      return fail(ErrorCode::AlreadyExists,
                  text(out.string(), " holds ", name.string(), ", which no demo made; choose another --out"));
  }
  std::string replaced;
  for (const char* product : kProducts)
    if (fs::remove_all(out / product, error) > 0 && !error)
      replaced += text(replaced.empty() ? "" : ", ", product);
  if (!replaced.empty()) log::info(text(out.string(), " held an earlier demo; made again: ", replaced));
  if (error) return fail(ErrorCode::Io, text("cannot clear ", out.string(), ": ", error.message()));
  return {};
}

// A rendered view against what the studio really looks like from there.
Scores against_truth(const SyntheticStudio& studio, const FilmPicture& picture, const Image& rgba) {
  const SyntheticShot truth = studio.shoot_view(picture.view, picture.frame);
  Image silhouette = to_image(truth.matte), mask = silhouette, rgb = *to_rgb(truth.frame);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    mask.pixels[i] = silhouette.pixels[i] >= 128 && rgba.pixels[4 * i + 3] >= 128 ? 255 : 0;
    for (std::size_t c = 0; c < 3; ++c)
      rgb.pixels[3 * i + c] = static_cast<std::uint8_t>(rgb.pixels[3 * i + c] * silhouette.pixels[i] / 255);
  }
  return score(over(rgba, {0, 0, 0}), rgb, erode_mask(mask, 2), silhouette);
}

Result<void> make_films(const DemoOptions& options, const SyntheticStudio& studio, DemoReport& report) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.out / "take");
  if (!take) return forward(take);
  const Result<render::OpenBackEnd> drawing = render::open_back_end(render::BackEnd::Auto);
  if (!drawing) return forward(drawing);
  const Result<Subject> subject = find_subject(**take);
  if (!subject) return forward(subject);

  FilmOptions film{.frame_rate = options.film_rate,
                   .frames = {},
                   .methods = kMethods,
                   .subject = subject->box,
                   .renderer = {}};
  for (int f = 0; f < (*take)->frame_count(); ++f) film.frames.push_back(f);
  film.renderer.back_end = drawing->back_end;
  film.renderer.background = {0.16f, 0.17f, 0.19f};
  film.renderer.cameras = options.blend;
  Result<std::unique_ptr<PictureSink>> freeview =
      open_picture_sink(options.out / "freeview.mp4", film.width, film.height, film.frame_rate);
  if (!freeview) return forward(freeview);
  Result<std::unique_ptr<PictureSink>> compare =
      open_picture_sink(options.out / "compare.mp4", 2 * film.width, film.height, film.frame_rate);
  if (!compare) return forward(compare);
  const CameraPath path = orbit_around((*take)->rig(), *subject, {.seconds = 1}).path;
  Result<FilmReport> done = render_film(**take, path, film, [&](FilmPicture picture) -> Result<void> {
    const Image linear = over(picture.renders[0], film.renderer.background),
                floating = over(picture.renders[1], film.renderer.background);
    if (Result<void> ok = (*freeview)->write(floating); !ok) return ok;
    if (Result<void> ok = (*compare)->write(side_by_side({linear, floating}, kMethods)); !ok) return ok;
    if (picture.index % options.score_every != options.score_every / 2) return {};
    for (std::size_t m = 0; m < kMethods.size(); ++m)
      report.scores[kMethods[m]].push_back(against_truth(studio, picture, picture.renders[m]));
    return {};
  });
  if (!done) return forward(done);
  if (Result<void> ok = (*freeview)->finish(); !ok) return ok;
  return (*compare)->finish();
}

nlohmann::json to_json(const DemoReport& report) {
  nlohmann::json j = {{"seconds", report.seconds}, {"stages", report.stage_seconds}};
  for (const auto& [method, scores] : report.scores) {
    Scores mean{};
    constexpr double Scores::*kMembers[] = {&Scores::psnr, &Scores::ssim, &Scores::cw_ssim,
                                            &Scores::psnr_shift, &Scores::sharpness};
    for (const Scores& s : scores)
      for (double Scores::*member : kMembers) mean.*member += s.*member / static_cast<double>(scores.size());
    j["mean"][method] = {{"psnr_mask", mean.psnr},       {"ssim_mask", mean.ssim},
                         {"cw_ssim_mask", mean.cw_ssim}, {"psnr_shift_mask", mean.psnr_shift},
                         {"sharpness", mean.sharpness},  {"views", scores.size()}};
  }
  return j;
}

}  // namespace

DemoOptions default_demo() {
  DemoOptions demo;
  demo.studio.frames = 24;
  demo.studio.studio.frame_rate = 12;
  demo.studio.studio.samples = 4;
  demo.studio.studio.defects = {
      .noise = 2, .lens_k1 = -0.05, .color_gain = 0.01, .calibration_error = 0.3, .green_spill = 0.2};
  demo.studio.take.label = "demo";
  return demo;
}

Result<DemoReport> run_demo(const DemoOptions& options) {
  const Clock::time_point begin = Clock::now();
  DemoReport report;
  Clock::time_point stage = begin;
  auto stage_done = [&](const char* name) {
    report.stage_seconds[name] = std::chrono::duration<double>(Clock::now() - stage).count();
    stage = Clock::now();
  };
  if (Result<void> ok = make_folder(options.out); !ok) return forward(ok);
  const Result<Claim> claim = claim_take(options.out, options.progress);
  if (!claim) return forward(claim);
  if (Result<void> ok = clear_earlier_demo(options.out); !ok) return forward(ok);

  SynthesizeOptions synthesize = options.studio;
  synthesize.out = options.out / "take";
  synthesize.progress = options.progress;
  if (Result<void> ok = synthesize_take(synthesize); !ok) return forward(ok);
  stage_done("synthesize");

  const ProcessOptions process{.take = synthesize.out, .matte = "chroma", .progress = options.progress};
  Result<ProcessReport> processed = process_take(process);
  if (!processed) return forward(processed);
  if (!processed->meshes.failures.empty())
    return fail(ErrorCode::BadData, processed->meshes.failures.front());
  stage_done("process");

  Result<SyntheticStudio> studio = SyntheticStudio::create(true_rig(synthesize), synthesize.studio);
  if (!studio) return forward(studio);
  if (Result<void> ok = make_films(options, *studio, report); !ok) return forward(ok);
  stage_done("render");

  report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (Result<void> ok = save_json(to_json(report), options.out / "report.json"); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
