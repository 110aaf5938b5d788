#include "pipeline/synthesize.h"

#include <cmath>
#include <cstring>
#include <mutex>

#include "core/file.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/progress.h"
#include "pipeline/recorded_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kRoomForTwo = 4.5;                     // metres from the middle to a camera
constexpr const char* kLabels[] = {"first", "second"};  // of two performers

// Portable float map: grey, little-endian, bottom row first as the format wants it.
std::string to_pfm(const std::vector<float>& depth, int width, int height) {
  std::string bytes = text("Pf\n", width, " ", height, "\n-1.0\n");
  for (int y = height - 1; y >= 0; --y)
    bytes.append(reinterpret_cast<const char*>(depth.data() + static_cast<std::size_t>(y) * width),
                 sizeof(float) * static_cast<std::size_t>(width));
  return bytes;
}

Result<void> write_truth(const SyntheticShot& shot, const TakeLayout& truth, const std::string& serial,
                         int frame, bool depth) {
  const fs::path matte = truth.matte(serial, frame);
  if (shot.frame.empty()) return {};
  if (Result<void> ok = save_png(to_image(shot.matte), matte); !ok) return ok;
  for (std::size_t i = 0; i < shot.matte_of.size(); ++i)
    if (Result<void> ok = save_png(to_image(shot.matte_of[i]), truth.label_matte(serial, kLabels[i], frame));
        !ok)
      return ok;
  if (!depth) return {};
  const fs::path file = truth.folder() / "depth" / serial / matte.filename().replace_extension(".pfm");
  return write_file(file, to_pfm(shot.depth, shot.matte.width, shot.matte.height));
}

Result<void> write_stage(const SyntheticStudio& studio, const TakeLayout& layout, SyntheticCast cast,
                         bool depth) {
  if (Result<void> ok = make_folder(layout.truth().meshes()); !ok) return ok;
  if (Result<void> ok = save_rig(studio.true_rig(), layout.truth().rig()); !ok) return ok;
  for (std::size_t i = 0; i < studio.true_rig().cameras.size(); ++i) {
    const std::string& serial = studio.true_rig().cameras[i].serial;
    if (Result<void> ok = make_folder(layout.truth().mattes() / serial); !ok) return ok;
    for (const char* label : kLabels)
      if (cast != SyntheticCast::One)
        if (Result<void> ok = make_folder(layout.truth().mattes() / serial / label); !ok) return ok;
    if (Result<void> ok = make_folder(layout.plate(serial).parent_path()); !ok) return ok;
    if (depth)
      if (Result<void> ok = make_folder(layout.truth().folder() / "depth" / serial); !ok) return ok;
    if (Result<void> ok = save_png(studio.plate(static_cast<int>(i)), layout.plate(serial)); !ok) return ok;
  }
  return {};
}

}  // namespace

Rig true_rig(const SynthesizeOptions& options) {
  SyntheticRigOptions rig = options.rig;
  rig.cast = options.studio.cast;
  if (rig.cast != SyntheticCast::One) rig.distance = std::max(rig.distance, kRoomForTwo);
  return synthetic_rig(rig);
}

Result<void> synthesize_take(const SynthesizeOptions& options) {
  if (options.frames < 1) return fail(ErrorCode::InvalidArgument, "a take needs at least one frame");
  Result<SyntheticStudio> studio = SyntheticStudio::create(true_rig(options), options.studio);
  if (!studio) return forward(studio);
  capture::TakeWriterOptions take_options = options.take;
  take_options.frame_rate = options.studio.frame_rate;
  Result<std::unique_ptr<capture::TakeWriter>> writer =
      capture::TakeWriter::create(options.out, studio->published_rig(), take_options);
  if (!writer) return forward(writer);
  const TakeLayout layout(options.out);
  if (Result<void> ok = write_stage(*studio, layout, options.studio.cast, options.depth); !ok) return ok;

  const std::vector<RigCamera>& cameras = studio->published_rig().cameras;
  ProgressPart progress(options.progress, "synthesize",
                        static_cast<std::size_t>(options.frames) * cameras.size());
  for (int frame = 0; frame < options.frames; ++frame) {
    if (is_cancelled(options.progress)) return cancelled();
    std::vector<std::optional<Error>> failures(cameras.size());
    parallel_for(cameras.size(), options.threads, [&](std::size_t i) {
      const SyntheticShot shot = studio->shoot(static_cast<int>(i), frame);
      Result<void> ok = (*writer)->write(shot.frame);
      if (ok) ok = write_truth(shot, layout.truth(), cameras[i].serial, frame, options.depth);
      if (!ok) failures[i] = ok.error();
      progress.advance();
    });
    for (const std::optional<Error>& e : failures)
      if (e) return Unexpected{*e};
    if (Result<void> ok = save_ply(studio->performer(frame), layout.truth().mesh(frame)); !ok) return ok;
  }
  if (Result<void> ok = (*writer)->finish(); !ok) return ok;
  return seal_take(options.out, options.progress);
}

}  // namespace floatstage::pipeline
