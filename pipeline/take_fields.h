#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/progress.h"
#include "render/camera_fields.h"
#include "render/scene.h"

namespace floatstage::pipeline {

/// The method that draws with fields.
inline constexpr const char* kFieldMethod = "floating-static";

/// fields/ of a take, and <serial>/<frame>.fields in it.
std::filesystem::path field_folder(const TakeLayout& layout);
std::filesystem::path field_path(const TakeLayout& layout, const std::string& serial, int frame);

/// What lies in fields/ of a take for one instant and is of this very scene, which was set with `rig`. Fields
/// of another mesh, of other photographs or mattes are left out, and `stale` says so in a sentence. BadData
/// names a file that was cut off or damaged; Io.
Result<std::shared_ptr<const render::FieldSet>> load_fields(const TakeLayout& layout, const Rig& rig,
                                                            int frame, const render::Scene& scene,
                                                            std::optional<std::string>* stale = nullptr);

/// The same, put into the scene; what is stale is said on the log. Nothing happens where nothing lies there.
Result<void> give_fields(const TakeLayout& layout, const Rig& rig, int frame, render::Scene& scene);

struct FieldOptions {
  std::vector<int> frames;
  int neighbors =
      4;  ///< of each camera, the nearest: the pairs that three blended photographs need on a ring
  render::FlowOptions flow;
  int threads = 0;
  bool redo = false;
  Progress* progress = nullptr;
};

struct FieldReport {
  int made = 0, kept = 0;             ///< files: a camera and instant each
  std::vector<std::string> failures;  ///< a sentence an instant that has no fields
};

/// Makes the files of a processed take that are missing or were made from something else than what is there
/// now, one a camera and instant, each whole or not at all: a run that is stopped goes on where it was. A bad
/// instant is reported and does not stop the others. Io; Cancelled. For those who have claimed the take.
Result<FieldReport> make_fields(capture::TakeReader& take, const FieldOptions& options);

}  // namespace floatstage::pipeline
