#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct ExportOptions {
  std::filesystem::path take, out;
  std::string format = "png8";            ///< png8, png16, exr
  std::vector<std::string> cameras = {};  ///< serials; empty: all
  std::vector<int> frames = {};           ///< empty: all
  int threads = 0;
  Progress* progress = nullptr;  ///< null: unwatched
};

/// The subject of every photograph that has a matte, for compositing elsewhere: <out>/<serial>/<frame>.png or
/// .exr with the estimated colours of the subject (straight, not premultiplied) and its opacity; a cloth's
/// light taken off where the take was keyed by chroma. Of a take with labels an EXR also has the opacity of
/// each as `<label>.A`, all of which add up to A, and PNGs lie in <out>/<serial>/<label>/, too, with the
/// label's own colours; label mattes are used as they lie there, so label_take() comes before. Pictures that
/// are there in this format, newer than their mattes, are kept. Returns how many there are. Errors:
/// InvalidArgument for a format that there is not; NotFound when the cameras have no mattes, or a label of
/// one has none; BadData for one of another size; those of files.
Result<int> export_layers(const ExportOptions& options);

}  // namespace floatstage::pipeline
