#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/chosen_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct ExportEasyVolcapOptions {
  std::filesystem::path take;
  LabelChoice labels = {};                ///< who of it: masks and points are theirs
  std::filesystem::path out;              ///< a folder that is not there yet, or empty
  std::vector<int> frames;                ///< at least one, in the order they are to have
  std::vector<std::string> cameras = {};  ///< serials; empty: all
  Progress* progress = nullptr;           ///< null: unwatched
};

struct ExportEasyVolcapReport {
  int frames = 0, pictures = 0, masks = 0;
  std::vector<int> left_out;  ///< of the frames: those without a picture of each camera
};

/// Instants as one sequence of EasyVolcap, whose cameras EasyMocap and OpenCV read, too (docs/adr/0288):
///
///   intri.yml, extri.yml           pinholes; pictures are without lens and skew
///   images/<serial>/000000.png     instants one after the other, from 0 on, whatever frames they were
///   masks/<serial>/000000.png      mattes; none of a camera that has none
///   vhulls/000000.ply              the hull of each, in metres
///
/// Such a sequence has a picture of each camera at each instant: frames where one is missing are left out.
/// Errors: of opening and of load_straight_instant(); NotFound where no frame has all cameras; whole or not
/// at all.
Result<ExportEasyVolcapReport> export_easyvolcap(const ExportEasyVolcapOptions& options);

}  // namespace floatstage::pipeline
