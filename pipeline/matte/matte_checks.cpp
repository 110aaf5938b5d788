#include "pipeline/matte/matte_checks.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/png.h"
#include "pipeline/matte/contradiction.h"
#include "pipeline/matte/hull_agreement.h"
#include "pipeline/matte/keyed_witnesses.h"

namespace floatstage::pipeline {
namespace {

// Mean change of opacity over frames in a row.
double flicker_of(const capture::TakeReader& take, const std::string& serial, const Progress* progress) {
  Image before;
  double sum = 0;
  int pairs = 0;
  for (int f = 0; f < take.frame_count() && !is_cancelled(progress); ++f) {
    Result<Image> now = load_png(take.layout().matte(serial, f));
    if (now && now->pixels.size() == before.pixels.size()) {
      double change = 0;
      for (std::size_t p = 0; p < now->pixels.size(); ++p)
        change += std::abs(now->pixels[p] - before.pixels[p]);
      sum += change / (255.0 * static_cast<double>(now->pixels.size()));
      ++pairs;
    }
    before = now ? std::move(*now) : Image();
  }
  return pairs ? sum / pairs : 0;
}

// Of mattes that are too few to judge one another, by keys of the other cameras. They alone are named.
Result<std::optional<MatteDoubt>> doubt_by_keys(capture::TakeReader& take, int frame, int threads,
                                                const MatteReport& report) {
  const Result<std::vector<recon::SilhouetteAgreement>> keyed =
      agreement_with_keyed(take, frame, report.cameras, threads);
  if (!keyed) return forward(keyed);
  Result<std::optional<MatteDoubt>> doubt = contradiction_in(take, *keyed);
  if (!doubt || !*doubt) return doubt;
  (*doubt)->cameras.clear();
  for (const CameraMattes& camera : report.cameras) (*doubt)->cameras.push_back(camera.serial);
  (*doubt)->why = "with the other cameras keyed likewise, " + (*doubt)->why;
  return doubt;
}

}  // namespace

Result<void> check_mattes(capture::TakeReader& take, const MatteTakeOptions& options, MatteReport& report) {
  parallel_for(report.cameras.size(), options.threads, [&](std::size_t i) {
    report.cameras[i].flicker = flicker_of(take, report.cameras[i].serial, options.progress);
  });
  std::vector<int> all = options.frames;
  for (int f = 0; options.frames.empty() && f < take.frame_count(); ++f) all.push_back(f);
  const std::size_t wanted = std::min(static_cast<std::size_t>(options.hull_frames), all.size());
  std::vector<int> frames;
  for (std::size_t i = 0; i < wanted; ++i) frames.push_back(all[(2 * i + 1) * all.size() / (2 * wanted)]);
  if (frames.empty()) return {};
  Result<std::vector<recon::SilhouetteAgreement>> worst =
      hull_agreement(take, frames, options.threads, options.progress);
  if (!worst) return forward(worst);
  report.worst = std::move(*worst);
  Result<std::optional<MatteDoubt>> contradiction = contradiction_in(take, report.worst);
  if (!contradiction) return forward(contradiction);
  if (!*contradiction && report.worst.empty()) {
    contradiction = doubt_by_keys(take, frames[frames.size() / 2], options.threads, report);
    if (!contradiction) return forward(contradiction);
  }
  if (Result<void> ok = keep_denials(take.layout(), *contradiction, {all.begin(), all.end()}); !ok) return ok;
  if (*contradiction) add_contradiction(std::move(**contradiction), report.doubts);
  for (CameraMattes& camera : report.cameras) {
    double sum = 0;
    int seen = 0;
    for (const recon::SilhouetteAgreement& a : report.worst)
      if (a.serial == camera.serial) sum += a.iou, ++seen;
    if (seen) camera.hull_agreement = sum / seen;
  }
  return {};
}

}  // namespace floatstage::pipeline
