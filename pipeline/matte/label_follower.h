#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "capture/take.h"
#include "core/image.h"
#include "core/matte.h"
#include "core/result.h"
#include "matting/labels/label_palette.h"
#include "pipeline/label_record.h"
#include "pipeline/matte/label_correction.h"
#include "pipeline/matte/label_doubts.h"
#include "pipeline/matte/label_givens.h"
#include "pipeline/matte/label_hull.h"
#include "pipeline/matte/label_instant.h"
#include "recon/label_volume.h"

namespace floatstage::pipeline {

/// Divides a take's mattes among labels, instant after instant, from those of which something was said: in
/// space, voxels of the hull take the label of what moved there, of whose colours cameras see them, and of
/// their neighbours; what each camera sees of that is the hint by which its matte is cut; and what pictures
/// then say is heard in space once more. docs/adr/0298.
///
/// Where all labels are said in one frame, labels begin there; what is said of some of them in other frames
/// corrects what was carried to those. docs/adr/0331.
class LabelFollower {
 public:
  /// A frame is finished: each once, in an order of their own.
  using Done = std::function<Result<void>(const LabelInstant& instant)>;

  /// `take` and `givens` outlive it. Threads: 0: one per core.
  LabelFollower(capture::TakeReader& take, const LabelRecord& record, const LabelGivens& givens, int threads);

  /// Every frame is reached from the nearest one in which all labels were said; without any, from the first
  /// by which each had been. Errors: NotFound where a photograph of which something was said has no matte;
  /// BadData where silhouettes bound nothing in a frame to begin from; those of reading; those of `done`.
  Result<void> run(const Done& done);

  /// After run(): what is not to be trusted.
  const std::vector<LabelDoubt>& doubts() const { return doubts_.all(); }

 private:
  std::uint32_t everybody() const;
  std::uint32_t said_in(int frame) const;
  std::vector<int> starts() const;
  Result<LabelInstant> open(int frame) const;
  Result<LabelInstant> start(int frame);
  Result<LabelInstant> begin(int frame);
  Result<LabelInstant> step(const LabelInstant& from, int frame);
  LabelHull hull_of(const LabelInstant& instant, const LabelPlaces& expected, const Disbelieved& before);
  LabelHullOf asked_of(const LabelInstant& instant, const LabelPlaces& expected,
                       const Disbelieved& before) const;
  void doubt(const LabelHull& hull, LabelInstant& instant);
  const std::map<int, LabelsAllowed>* said_of(int frame) const;
  recon::LabelVolume::Costs begin_costs(const recon::LabelVolume& volume, const LabelInstant& instant) const;
  static std::vector<std::vector<float>> ways_from(const recon::LabelVolume& volume,
                                                   const std::vector<std::vector<std::size_t>>& start);
  static void ask_ways(const std::vector<std::vector<float>>& ways, std::size_t voxel, float* of);
  void correct(const recon::LabelVolume& volume, const LabelInstant& instant,
               const LabelCorrection& correction, recon::LabelVolume::Costs& costs);
  recon::LabelVolume::Costs carried_costs(const recon::LabelVolume& volume, const LabelInstant& from) const;
  std::vector<std::uint8_t> settle(const recon::LabelVolume& volume, const recon::LabelVolume::Costs& costs,
                                   const LabelInstant* near, int rounds, LabelInstant& instant);
  void hear(const recon::LabelVolume& volume, const LabelInstant& instant,
            const std::vector<std::uint8_t>& voxels, recon::LabelVolume::Costs& costs) const;
  void split(const recon::LabelVolume& volume, const std::vector<std::uint8_t>& voxels,
             const LabelInstant* near, LabelInstant& instant) const;
  void finish(const recon::LabelVolume& volume, const std::vector<std::uint8_t>& voxels,
              const LabelInstant* from, LabelInstant& instant);
  void split_alone(const LabelInstant& from, LabelInstant& instant) const;
  Result<void> walk(const LabelInstant& from, int end, const Done& done, LabelInstant& last);

  capture::TakeReader& take_;
  const std::vector<std::string> names_;
  const LabelGivens& givens_;
  const int threads_;
  const std::vector<std::uint32_t> anything_;  // empty: of pixels of which nothing was said
  double voxel_ = 0;
  matting::LabelPalette palette_, said_palette_;  // … as of when somebody last said who is who
  LabelDoubts doubts_;
};

}  // namespace floatstage::pipeline
