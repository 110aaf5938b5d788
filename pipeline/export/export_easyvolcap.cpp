#include "pipeline/export/export_easyvolcap.h"

#include <cstdio>
#include <set>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/export/instant.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

std::string numbered(int instant, const char* extension) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d", instant);
  return text(name, extension);
}

Result<void> make_folders(const StraightInstant& instant, const fs::path& folder) {
  if (Result<void> ok = make_folder(folder / "vhulls"); !ok) return ok;
  for (std::size_t c = 0; c < instant.rig.cameras.size(); ++c) {
    const std::string& serial = instant.rig.cameras[c].serial;
    if (Result<void> ok = make_folder(folder / "images" / serial); !ok) return ok;
    if (instant.mattes[c].empty()) continue;
    if (Result<void> ok = make_folder(folder / "masks" / serial); !ok) return ok;
  }
  return {};
}

Result<void> write_instant(const StraightInstant& instant, const fs::path& folder,
                           ExportEasyVolcapReport& report) {
  if (Result<void> ok = make_folders(instant, folder); !ok) return ok;
  const std::string name = numbered(report.frames, ".png");
  std::vector<Result<void>> saved(instant.pictures.size());
  parallel_for(saved.size(), 0, [&](std::size_t c) {
    const fs::path own = fs::path(instant.rig.cameras[c].serial) / name;
    saved[c] = save_png(instant.pictures[c], folder / "images" / own);
    if (saved[c] && !instant.mattes[c].empty())
      saved[c] = save_png(instant.mattes[c], folder / "masks" / own);
  });
  for (const Result<void>& ok : saved)
    if (!ok) return ok;
  for (const Image& matte : instant.mattes) report.masks += matte.empty() ? 0 : 1;
  report.pictures += static_cast<int>(instant.pictures.size());
  return save_ply(instant.mesh, folder / "vhulls" / numbered(report.frames++, ".ply"));
}

// How many cameras a whole instant has.
std::size_t cameras_of(const capture::TakeReader& take, const std::vector<std::string>& serials) {
  return serials.empty() ? take.rig().cameras.size() : std::set(serials.begin(), serials.end()).size();
}

Result<void> write_cameras(const Rig& rig, const fs::path& folder) {
  const Result<const calib::RigFormat*> format = calib::rig_format("opencv", folder);
  if (!format) return forward(format);
  return (*format)->write(rig, {}, folder);
}

}  // namespace

Result<ExportEasyVolcapReport> export_easyvolcap(const ExportEasyVolcapOptions& options) {
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "there is no frame to export");
  Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(options.take, options.labels);
  if (!take) return forward(take);
  Result<UnfinishedFolder> out = UnfinishedFolder::begin(options.out);
  if (!out) return forward(out);
  SceneLoader loader(**take, true);
  ExportEasyVolcapReport report;
  ProgressPart progress(options.progress, "frames", options.frames.size());
  for (const int frame : options.frames) {
    if (is_cancelled(options.progress)) return cancelled_unwritten();
    const Result<StraightInstant> instant = load_straight_instant(**take, loader, frame, options.cameras);
    if (!instant) return forward(instant);
    progress.advance();
    if (instant->pictures.size() < cameras_of(**take, options.cameras)) {
      report.left_out.push_back(frame);
      continue;
    }
    if (report.frames == 0)
      if (Result<void> ok = write_cameras(instant->rig, out->folder()); !ok) return forward(ok);
    if (Result<void> ok = write_instant(*instant, out->folder(), report); !ok) return forward(ok);
  }
  if (report.frames == 0)
    return fail(ErrorCode::NotFound, text(options.take.string(),
                                          ": none of these frames has a picture of each camera, as a "
                                          "sequence of EasyVolcap wants; choose others with --frames, or "
                                          "cameras that have them with --cameras"));
  if (Result<void> ok = out->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
