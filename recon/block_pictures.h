#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/rig.h"
#include "recon/hull_input.h"

namespace floatstage::recon {

/// A silhouette in square blocks of pixels, 128 along the picture's longer side: where a block holds any
/// subject, and sums over rectangles of blocks.
struct BlockPicture {
  bool known = false;   ///< the camera has a matte or an outline
  bool inside = false;  ///< its subject does not touch the picture's border
  bool whole = false;   ///< taken to show the whole subject: what lies outside the picture is background
  int block = 1;        ///< px
  int columns = 0, rows = 0;
  std::vector<std::uint8_t> subject;   ///< row by row: 1 where a pixel of the block is subject
  std::vector<std::uint8_t> block_at;  ///< by px, along the longer side: which block it is in
  std::vector<int> sums;               ///< (columns + 1) x (rows + 1): blocks with subject above and left

  /// Blocks with subject in a rectangle of blocks, bounds included.
  int count(int x0, int y0, int x1, int y1) const { return count(sums, x0, y0, x1, y1); }
  int count(const std::vector<int>& sum, int x0, int y0, int x1, int y1) const {
    const auto at = [&](int x, int y) { return sum[static_cast<std::size_t>(y) * (columns + 1) + x]; };
    return at(x1 + 1, y1 + 1) - at(x0, y1 + 1) - at(x1 + 1, y0) + at(x0, y0);
  }
  /// Sums of any picture of the same blocks.
  void sum_up(const std::vector<std::uint8_t>& blocks, std::vector<int>& sum) const;
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * columns + x; }
};

/// Where a ball is in a picture, px: nothing of it lies outside. `near`: the camera is in it or close by;
/// `beside`: the camera cannot see any of it, because it is behind it or outside the cone around the picture.
struct BallExtent {
  double left = 0, right = 0, top = 0, bottom = 0;
  bool beside = false, near = false;
};

/// The silhouettes of one instant in blocks, and balls seen from their cameras. Keeps its memory.
class BlockPictures {
 public:
  void fill(const Rig& rig, const HullInput& input);

  std::size_t size() const { return pictures_.size(); }
  int known() const { return known_; }
  const BlockPicture& operator[](std::size_t camera) const { return pictures_[camera]; }
  const CameraModel& model(std::size_t camera) const { return lenses_[camera].model; }

  BallExtent extent(std::size_t camera, const Eigen::Vector3d& center, double radius) const;

  /// Whether a camera whose subject touches no border is taken to show all of it (the default after fill()).
  void set_whole(std::size_t camera, bool whole) {
    pictures_[camera].whole = whole && pictures_[camera].inside;
  }

  enum class Answer { NotSeen, Subject, Background };
  /// What a camera says about a ball. To one that shows the whole subject, all outside its picture is
  /// background; to another it is not seen. A large ball is seen wherever it may reach the picture, and is
  /// background only where all of it is seen. Of a small one the centre decides whether it is seen, and what
  /// lies in the picture whether it is background.
  Answer ask(std::size_t camera, const Eigen::Vector3d& center, double radius, bool small) const;

  /// Blocks that the ball reaches, clipped to the picture; false when there are none.
  bool blocks_of(std::size_t camera, const Eigen::Vector3d& center, double radius, int& x0, int& y0, int& x1,
                 int& y1) const;

 private:
  struct View {
    CameraModel model;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    bool pinhole = true;
    double stretch = 1;           ///< of the lens: the most px that a step of one px without lens can become
    double cosine = 0, sine = 1;  ///< of the largest angle between the axis and what the picture shows
  };

  std::vector<BlockPicture> pictures_;
  std::vector<View> lenses_;
  int known_ = 0;
};

}  // namespace floatstage::recon
