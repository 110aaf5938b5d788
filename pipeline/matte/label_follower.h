#pragma once

#include <functional>
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
#include "pipeline/matte/label_givens.h"
#include "recon/label_volume.h"

namespace floatstage::pipeline {

/// The labels of one instant: what is carried to the next.
struct LabelInstant {
  int frame = -1;
  std::vector<Image> pictures, mattes;  ///< by camera: RGB and the sum; empty where there is none
  std::vector<Image> sure;              ///< labels of the pixels whose rays meet voxels of no other, else 0
  std::vector<Image> labels;            ///< by camera, of its pixels: 0 nobody; empty where there is no sum
  std::vector<std::vector<Eigen::Vector3i>> places;  ///< by label - 1: its voxels
  std::vector<Eigen::Vector3d> motion;               ///< by label - 1: voxels a frame
  double merged = 0;  ///< the largest share of a label that lies at another one
};

/// Divides a take's mattes among labels, instant after instant, from those of which something was said: in
/// space, voxels of the hull take the label of what moved there, of whose colours cameras see them, and of
/// their neighbours; what each camera sees of that is the hint by which its matte is cut; and what pictures
/// then say is heard in space once more. docs/adr/0298.
class LabelFollower {
 public:
  /// A frame is finished: each once, in an order of their own.
  using Done = std::function<Result<void>(const LabelInstant& instant)>;

  /// `take` and `givens` outlive it. Threads: 0: one per core.
  LabelFollower(capture::TakeReader& take, const LabelRecord& record, const LabelGivens& givens, int threads);

  /// Every frame is reached from the nearest one of which something was said. Errors: NotFound where a frame
  /// of which something was said has no mattes; BadData where silhouettes bound nothing there; those of
  /// reading; those of `done`.
  Result<void> run(const Done& done);

  /// After run(): what is not to be trusted.
  const std::vector<LabelDoubt>& doubts() const { return doubts_; }

 private:
  Result<LabelInstant> open(int frame) const;
  Result<LabelInstant> begin(int frame);
  Result<LabelInstant> step(const LabelInstant& from, int frame);
  Result<std::optional<recon::LabelVolume>> volume_of(const LabelInstant& instant, bool needed);
  recon::LabelVolume::Costs begin_costs(const recon::LabelVolume& volume, const LabelInstant& instant) const;
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
  void doubt_merge(const LabelInstant& instant);
  void doubt_loss(const LabelInstant& instant);
  void doubt_meeting(const LabelInstant& onward, const LabelInstant& backward);
  void doubt(const std::string& why, const std::string& serial, int frame);
  int most_hidden(const LabelInstant& instant, int label) const;

  capture::TakeReader& take_;
  const std::vector<std::string> names_;
  const LabelGivens& givens_;
  const int threads_;
  const std::vector<std::uint32_t> anything_;  // empty: of pixels of which nothing was said
  double voxel_ = 0;
  matting::LabelPalette palette_;
  std::vector<LabelDoubt> doubts_;
};

}  // namespace floatstage::pipeline
