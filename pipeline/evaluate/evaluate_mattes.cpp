#include "pipeline/evaluate/evaluate_mattes.h"

#include <algorithm>

#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/import/matte_files.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// What files add up to: one, or one a label. Empty where one is missing.
Result<Image> load_matte(const std::vector<fs::path>& files) {
  Image sum;
  for (const fs::path& file : files) {
    if (!is_there(file)) return Image();
    Result<Image> picture = load_png(file);
    if (!picture) return forward(picture);
    if (picture->channels != 1) {
      Result<Image> alpha = matte_from_picture(*picture);
      if (!alpha) return fail(alpha.error().code, text(file.string(), " ", alpha.error().message));
      picture = std::move(alpha);
    }
    if (sum.empty()) {
      sum = std::move(*picture);
      continue;
    }
    if (sum.width != picture->width || sum.height != picture->height)
      return fail(ErrorCode::BadData, text(file.string(), " has another size than ", files.front().string()));
    for (std::size_t p = 0; p < sum.pixels.size(); ++p)
      sum.pixels[p] = static_cast<std::uint8_t>(std::min(255, sum.pixels[p] + picture->pixels[p]));
  }
  return sum;
}

// Where the truth of a frame lies: as mattes do in a take.
std::vector<fs::path> truth_files(const capture::TakeReader& take, const fs::path& truth,
                                  const std::string& serial, int frame) {
  std::vector<fs::path> files;
  for (const fs::path& matte : take.layout().matte_files(serial, frame))
    files.push_back(truth / matte.lexically_relative(take.layout().mattes()));
  return files;
}

struct Pair {
  int frame = -2;
  Image matte, truth;
};

void add(MatteScores& sum, const MatteScores& s, double weight) {
  for (double MatteScores::*score :
       {&MatteScores::sad, &MatteScores::mad, &MatteScores::mse, &MatteScores::gradient,
        &MatteScores::connectivity, &MatteScores::iou, &MatteScores::boundary_f})
    sum.*score += weight * s.*score;
}

}  // namespace

Result<std::vector<CameraMatteScores>> evaluate_mattes(const capture::TakeReader& take, const fs::path& truth,
                                                       const std::vector<int>& frames, Progress* watch) {
  Result<MatteEdits> edits = load_matte_edits(take.layout().edits());
  if (!edits) return forward(edits);
  std::vector<CameraMatteScores> all;
  ProgressPart progress(watch, "mattes", take.rig().cameras.size() * frames.size());
  for (const RigCamera& camera : take.rig().cameras) {
    CameraMatteScores scores{
        .serial = camera.serial, .mean = {}, .dtssd = {}, .effort = effort_of(edits->cameras[camera.serial])};
    Pair before;
    double flicker = 0;
    int pairs = 0;
    for (const int frame : frames) {
      progress.advance();
      const std::vector<fs::path> files = take.layout().matte_files(camera.serial, frame);
      Result<Image> matte = load_matte(files),
                    real = load_matte(truth_files(take, truth, camera.serial, frame));
      if (!matte) return forward(matte);
      if (!real) return forward(real);
      if (matte->empty() || real->empty()) continue;
      if (matte->width != real->width || matte->height != real->height)
        return fail(ErrorCode::BadData, text(files.front().string(), " is ", matte->width, "x", matte->height,
                                             " but its truth is ", real->width, "x", real->height));
      Pair now{frame, std::move(*matte), std::move(*real)};
      const MatteScores s = score_matte(now.matte, now.truth);
      add(scores.mean, s, 1);
      ++scores.frames;
      if (s.iou < scores.worst_iou || scores.worst_frame < 0)
        scores.worst_iou = s.iou, scores.worst_frame = frame;
      if (before.frame == frame - 1 && before.matte.width == now.matte.width &&
          before.matte.height == now.matte.height) {
        flicker += matte_dtssd(before.matte, now.matte, before.truth, now.truth);
        ++pairs;
      }
      before = std::move(now);
    }
    if (scores.frames == 0) continue;
    const MatteScores sum = std::exchange(scores.mean, {});
    add(scores.mean, sum, 1.0 / scores.frames);
    if (pairs > 0) scores.dtssd = flicker / pairs;
    all.push_back(std::move(scores));
  }
  if (all.empty())
    return fail(ErrorCode::NotFound,
                text(truth.string(), " holds no true matte of a frame that ", take.layout().mattes().string(),
                     " has; it needs <serial>/<frame>.png"));
  return all;
}

}  // namespace floatstage::pipeline
