#include "apps/evaluate/matte_table.h"

#include <cmath>
#include <cstdio>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/terminal/progress_bar.h"
#include "apps/terminal/text_options.h"
#include "capture/take.h"
#include "pipeline/evaluate/evaluate_mattes.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;

struct MatteColumn {
  const char* name;
  double pipeline::MatteScores::*score;
};
constexpr MatteColumn kMatteColumns[] = {{"sad", &pipeline::MatteScores::sad},
                                         {"mse", &pipeline::MatteScores::mse},
                                         {"mad", &pipeline::MatteScores::mad},
                                         {"grad", &pipeline::MatteScores::gradient},
                                         {"conn", &pipeline::MatteScores::connectivity},
                                         {"iou", &pipeline::MatteScores::iou},
                                         {"boundary_f", &pipeline::MatteScores::boundary_f}};

json to_json(const pipeline::CameraMatteScores& c) {
  json j = {{"frames", c.frames},
            {"worst_frame", c.worst_frame},
            {"worst_iou", c.worst_iou},
            {"effort",
             {{"keyframes", c.effort.keyframes},
              {"clicks", c.effort.clicks},
              {"scribbles", c.effort.scribbles},
              {"masks", c.effort.masks}}}};
  for (const MatteColumn& column : kMatteColumns) j[column.name] = c.mean.*column.score;
  j["dtssd"] = c.dtssd ? json(*c.dtssd) : json();
  return j;
}

// Each camera counts alike; dtSSD over those that have frames in a row.
pipeline::CameraMatteScores mean(const std::vector<pipeline::CameraMatteScores>& cameras) {
  pipeline::CameraMatteScores m{.serial = "mean", .mean = {}, .dtssd = {}, .effort = {}};
  double flicker = 0;
  int flickering = 0;
  for (const pipeline::CameraMatteScores& c : cameras) {
    for (const MatteColumn& column : kMatteColumns)
      m.mean.*column.score += c.mean.*column.score / static_cast<double>(cameras.size());
    if (c.dtssd) flicker += *c.dtssd, ++flickering;
    if (c.worst_iou <= m.worst_iou) m.worst_iou = c.worst_iou, m.worst_frame = c.worst_frame;
    m.frames += c.frames;
    m.effort.keyframes += c.effort.keyframes, m.effort.clicks += c.effort.clicks;
    m.effort.scribbles += c.effort.scribbles, m.effort.masks += c.effort.masks;
  }
  if (flickering) m.dtssd = flicker / flickering;
  return m;
}

}  // namespace

Result<void> report_mattes(const MatteTruth& given) {
  Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(given.take, given.labels);
  if (!take) return forward(take);
  Result<std::vector<int>> frames = parse_frames(given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  const std::filesystem::path truth = given.truth.empty() ? (*take)->layout().truth().mattes() : given.truth;
  ProgressBar bar;
  Result<std::vector<pipeline::CameraMatteScores>> cameras =
      pipeline::evaluate_mattes(**take, truth, *frames, &bar);
  if (!cameras) return forward(cameras);
  const pipeline::CameraMatteScores total = mean(*cameras);
  std::printf("%-12s", "camera");
  for (const MatteColumn& column : kMatteColumns) std::printf(" %11s", column.name);
  std::printf(" %11s %7s\n", "dtssd", "effort");
  std::vector<pipeline::CameraMatteScores> rows = *cameras;
  rows.push_back(total);
  for (const pipeline::CameraMatteScores& c : rows) {
    std::printf("%-12s", c.serial.c_str());
    for (const MatteColumn& column : kMatteColumns) std::printf(" %11.5g", c.mean.*column.score);
    std::printf(" %11.5g %3d/%-3d\n", c.dtssd.value_or(std::nan("")), c.effort.keyframes,
                c.effort.clicks + c.effort.scribbles + c.effort.masks);
  }
  if (given.json_file.empty()) return {};
  json j = {{"take", given.take.string()}, {"truth", truth.string()}, {"mean", to_json(total)}};
  for (const pipeline::CameraMatteScores& c : *cameras) j["per_camera"][c.serial] = to_json(c);
  return pipeline::save_json(j, given.json_file);
}

}  // namespace floatstage::apps
