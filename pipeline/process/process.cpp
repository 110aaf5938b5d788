#include "pipeline/process/process.h"

#include <chrono>
#include <iterator>

#include <nlohmann/json.hpp>

#include "capture/take.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/hull_record.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/matte/settle_added.h"
#include "pipeline/mesh_record.h"
#include "pipeline/process/mesh_maker.h"
#include "pipeline/process/pose_doubts.h"

namespace floatstage::pipeline {
namespace {

Result<StageReport> make_mattes(capture::TakeReader& take, const ProcessOptions& options,
                                ProcessReport& report) {
  Result<MatteReport> made = matte_take(take, matte_options(options));
  if (!made) return forward(made);
  StageReport stage;
  for (CameraMattes& camera : made->cameras) {
    stage.made += camera.made, stage.kept += camera.kept;
    stage.others += camera.others, stage.gaps += camera.gaps;
    std::move(camera.failures.begin(), camera.failures.end(), std::back_inserter(stage.failures));
  }
  report.remarks = std::move(made->remarks);
  report.distrusted = made->distrusted;
  report.doubts = std::move(made->doubts);
  return stage;
}

// A matte that the key refused to make is no failure any more when the others' evidence made it.
void forget_failures(ProcessReport& report) {
  for (const HealedCamera& camera : report.healed)
    for (const int frame : camera.filled)
      std::erase_if(report.mattes.failures, [&](const std::string& sentence) {
        return sentence.starts_with(text("camera '", camera.serial, "', frame ", frame, ":"));
      });
}

}  // namespace

MatteTakeOptions matte_options(const ProcessOptions& options) {
  return {.take = options.take,
          .how = options.matte,
          .guide = options.guide,
          .cameras = options.cameras,
          .frames = options.frames,
          .threads = options.threads,
          .redo = options.redo,
          .check = false,
          .hide_added = options.hide_added,
          .progress = options.progress};
}

Result<recon::HullOptions> settle_hull_options(const capture::TakeReader& take, const ProcessOptions& options,
                                               const MeshRecord& record) {
  recon::HullOptions hull = *hull_options(HullWords());
  if (options.hull) {
    hull = *options.hull;
  } else if (std::optional<recon::HullOptions> earlier = parse_hull_options(record.options)) {
    hull = *earlier;
  }
  if (record.options.is_null() || record.options == describe(hull) || options.redo) return hull;
  return fail(
      ErrorCode::AlreadyExists,
      text(take.layout().meshes().string(), " was made with other hull options (", record.options.dump(),
           "); leave the flags out to go on with them, or add --redo to make its meshes again"));
}

Result<ProcessReport> process_take(const ProcessOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  const Result<Claim> claim = claim_take(options.take, options.progress);
  if (!claim) return forward(claim);
  const Result<std::vector<std::string>> added = settle_added(*opened, options.hide_added, options.threads);
  if (!added) return forward(added);
  capture::TakeReader& take = **opened;
  std::vector<int> frames = options.frames;
  for (int f = 0; options.frames.empty() && f < take.frame_count(); ++f) frames.push_back(f);
  ProcessReport report{.frames = static_cast<int>(frames.size()),
                       .cameras = static_cast<int>(options.cameras.empty() ? take.rig().cameras.size()
                                                                           : options.cameras.size()),
                       .mattes = {},
                       .meshes = {},
                       .remarks = {}};

  sweep_temporaries(take.layout().meshes());
  Result<MeshRecord> record = load_mesh_record(take.layout());
  if (!record) return forward(record);
  const Result<recon::HullOptions> hull = settle_hull_options(take, options, *record);
  if (!hull) return forward(hull);
  Result<StageReport> mattes = make_mattes(take, options, report);
  if (!mattes) return forward(mattes);
  report.mattes = std::move(*mattes);
  report.remarks.insert(report.remarks.begin(), added->begin(), added->end());
  if (Result<void> ok = make_meshes(take, options, *hull, std::move(*record), frames, report); !ok)
    return forward(ok);
  forget_failures(report);
  if (report.meshes.made > 0 || options.gathered) {
    Result<std::vector<std::string>> doubts = pose_doubts(take, frames, options.threads, options.progress);
    if (!doubts) return forward(doubts);
    report.pose_doubts = *std::move(doubts);
  }
  if (options.fields) {
    Result<FieldReport> fields = make_fields(take, {.frames = frames,
                                                    .flow = {},
                                                    .threads = options.threads,
                                                    .redo = options.redo,
                                                    .progress = options.progress});
    if (!fields) return forward(fields);
    report.fields = *std::move(fields);
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace floatstage::pipeline
