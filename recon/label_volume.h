#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "core/image.h"
#include "core/matte.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::recon {

/// The visual hull of an instant as voxels, to say which of them are whose: labels are 1 … `labels`, and 0 is
/// nobody's, for what the silhouettes leave between bodies and no body fills. Voxels lie on one lattice of
/// the world, so that those of two instants can be compared. Read-only after construction, so thread safe.
class LabelVolume {
 public:
  /// Costs of each voxel, labels + 1 numbers each, in nats: what a label costs it.
  using Costs = std::vector<float>;

  /// The voxels of edge `voxel` (metres) in the box in which visual_hull() looks, into whose footprint some
  /// subject (alpha >= 128) falls in every camera that sees them, of as many as bear witness there; one
  /// camera in ten may deny it. Empty mattes are of cameras that do not know. BadData where the silhouettes
  /// bound nothing, or so much that it takes more than 64 million voxels.
  static Result<LabelVolume> carve(const Rig& rig, std::span<const Matte> mattes, double voxel, int labels,
                                   int threads);
  /// An edge with which the box of these mattes has about `voxels` voxels, metres; 0 where they
  /// bound nothing.
  static double edge_for(const Rig& rig, std::span<const Matte> mattes, int voxels);

  std::size_t size() const { return places_.size(); }
  double voxel() const { return voxel_; }
  int labels() const { return labels_; }
  /// Lattice coordinates: the voxel's middle is voxel() times (place + 0.5).
  const std::vector<Eigen::Vector3i>& places() const { return places_; }
  Costs no_costs() const { return Costs(size() * static_cast<std::size_t>(labels_ + 1), 0.f); }

  /// Voxels' edges from each voxel to the nearest of these places, which need not be voxels (chamfer 3-4-5);
  /// kFar where there is none.
  std::vector<float> distance_to(std::span<const Eigen::Vector3i> places) const;
  /// The same on a way through voxels, from those of `start`; kFar where no way leads.
  std::vector<float> way_from(std::span<const std::size_t> start) const;
  static constexpr float kFar = 1e4F;

  /// The voxels in front, in a camera's picture: those that no voxel of a label > 0 hides by more than its
  /// own size. `labels` of all voxels; empty: every voxel hides.
  std::vector<std::size_t> visible(int camera, std::span<const std::uint8_t> labels) const;
  /// Lowers the costs of voxels in front by what their pixels say: `says` has for each pixel of the camera's
  /// picture `labels()` numbers, those of label 1 first; pixels that say nothing have none above 0 or below.
  void hear(int camera, std::span<const std::uint8_t> labels, std::span<const float> says, float weight,
            Costs& costs) const;
  /// Labels of least cost, `smooth` nats for each two neighbours that differ.
  std::vector<std::uint8_t> label(const Costs& costs, double smooth) const;

  /// What a camera sees of the labels, nearest voxels first, in its own pixels: 0 where none is. It is as
  /// coarse as voxels are, cell() px.
  Image picture(int camera, std::span<const std::uint8_t> labels) const;
  int cell(int camera) const { return views_[static_cast<std::size_t>(camera)].cell; }
  /// The nearest voxel that a pixel sees, of those of a label > 0 where `labels` of all voxels is not empty;
  /// size() where none is.
  std::size_t seen_at(int camera, int x, int y, std::span<const std::uint8_t> labels = {}) const;
  /// The voxels that hang together with one through voxels of its own label, itself included.
  std::vector<std::size_t> piece_of(std::size_t voxel, std::span<const std::uint8_t> labels) const;

  /// How deep labels are in one another: of each, the share of its voxels with one of another label no
  /// further than `reach` edges away.
  std::vector<double> merged(std::span<const std::uint8_t> labels, int reach) const;

 private:
  struct Seen {
    std::uint16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // cells, x1 and y1 included
    float depth = -1;                              // metres; < 0: not in the picture
  };
  struct View {
    int cell = 1, columns = 0, rows = 0, width = 0, height = 0;
    std::vector<Seen> seen;  // a voxel
  };
  LabelVolume(const Rig& rig, double voxel, int labels)
      : voxel_(voxel), labels_(labels), views_(rig.cameras.size()) {}
  void look(const Rig& rig, int threads);
  void link();
  std::vector<float> nearest(const View& view, std::span<const std::uint8_t> labels) const;
  std::size_t at(const Eigen::Vector3i& place) const;  // in index_
  bool inside(const Eigen::Vector3i& place) const;

  double voxel_;
  int labels_;
  std::vector<View> views_;
  std::vector<Eigen::Vector3i> places_;
  Eigen::Vector3i low_ = Eigen::Vector3i::Zero(), count_ = Eigen::Vector3i::Zero();
  std::vector<std::int32_t> index_;  // a place of the box: its voxel, or -1
};

}  // namespace floatstage::recon
