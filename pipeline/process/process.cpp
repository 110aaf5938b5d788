#include "pipeline/process/process.h"

#include <chrono>
#include <iterator>

#include <nlohmann/json.hpp>

#include "capture/take.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/hull_record.h"
#include "pipeline/matte/label_take.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/matte/settle_added.h"
#include "pipeline/mesh_record.h"
#include "pipeline/process/mesh_maker.h"
#include "pipeline/process/pose_doubts.h"

namespace floatstage::pipeline {
namespace {

Result<void> make_mattes(capture::TakeReader& take, const ProcessOptions& options, ProcessReport& report) {
  Result<MatteReport> made = matte_take(take, matte_options(options));
  if (!made) return forward(made);
  StageReport& stage = report.mattes;
  for (CameraMattes& camera : made->cameras) {
    stage.made += camera.made, stage.kept += camera.kept;
    stage.others += camera.others, stage.gaps += camera.gaps;
    std::move(camera.failures.begin(), camera.failures.end(), std::back_inserter(stage.failures));
  }
  report.remarks = std::move(made->remarks);
  report.distrusted = made->distrusted;
  report.doubts = std::move(made->doubts);
  return {};
}

// Mattes that have changed, divided among the take's labels anew.
Result<void> divide(capture::TakeReader& take, const ProcessOptions& options, ProcessReport& report) {
  Result<LabelTakeReport> labels =
      label_take(take, {.threads = options.threads, .redo = false, .progress = options.progress});
  if (!labels) return forward(labels);
  std::move(labels->doubts.begin(), labels->doubts.end(), std::back_inserter(report.doubts));
  return {};
}

// The take with nobody in it but the chosen labels, whose mattes are made first.
Result<void> choose_divided(Result<std::unique_ptr<capture::TakeReader>>& take, const ProcessOptions& options,
                            ProcessReport& report) {
  if (Result<void> ok = make_mattes(**take, options, report); !ok) return ok;
  if (Result<void> ok = divide(**take, options, report); !ok) return ok;
  Result<std::unique_ptr<capture::TakeReader>> chosen = choose(std::move(*take), options.labels);
  if (!chosen) return forward(chosen);
  take = std::move(chosen);
  return {};
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
  if (options.fields && !options.labels.everybody())
    return fail(ErrorCode::InvalidArgument,
                "fields are made of a take with everybody in it; leave out the labels");
  ProcessReport report;
  if (!options.labels.everybody())
    if (Result<void> ok = choose_divided(opened, options, report); !ok) return forward(ok);
  capture::TakeReader& take = **opened;
  std::vector<int> frames = options.frames;
  for (int f = 0; options.frames.empty() && f < take.frame_count(); ++f) frames.push_back(f);
  report.frames = static_cast<int>(frames.size());
  report.cameras =
      static_cast<int>(options.cameras.empty() ? take.rig().cameras.size() : options.cameras.size());
  sweep_temporaries(take.layout().meshes());
  Result<MeshRecord> record = load_mesh_record(take.layout());
  if (!record) return forward(record);
  const Result<recon::HullOptions> hull = settle_hull_options(take, options, *record);
  if (!hull) return forward(hull);
  if (options.labels.everybody())
    if (Result<void> ok = make_mattes(take, options, report); !ok) return forward(ok);
  report.remarks.insert(report.remarks.begin(), added->begin(), added->end());
  if (Result<void> ok = make_meshes(take, options, *hull, std::move(*record), frames, report); !ok)
    return forward(ok);
  forget_failures(report);
  if (options.labels.everybody())
    if (Result<void> ok = divide(take, options, report); !ok) return forward(ok);
  if (options.labels.everybody() && report.camera_doubts.empty() &&
      (report.meshes.made > 0 || options.gathered)) {
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
