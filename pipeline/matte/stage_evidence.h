#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/image.h"
#include "core/rig.h"
#include "matting/cast_shadows.h"
#include "matting/keyers/plate.h"
#include "matting/known_by_plate.h"
#include "matting/still_backdrop.h"
#include "recon/occupancy.h"
#include "recon/shared_view.h"

namespace floatstage::pipeline {

/// What still cameras know of their stages, and what that tells of the pictures of an instant: each camera by
/// itself, of shadows on floor and walls by what several see there (matting/cast_shadows.h), and of clothes
/// in the stage's colours by what several see changed above it.
///
/// A pixel that is only darker or brighter than its empty stage may show the subject or his shadow, and tells
/// nothing of itself. Shadows and reflexes lie on the floor (or in it): where other cameras see something
/// changed above the floor, it is the subject. Where a shadow falls and they do, it may be either: somebody
/// before his own shadow is as dark as it. Deterministic at any thread count; one caller at a time.
class StageEvidence {
 public:
  /// `sizes`: of the pictures that are looked at, smaller than the photographs.
  StageEvidence(const Rig& rig, std::vector<Eigen::Vector2i> sizes);

  /// Of such a size.
  void learn(std::size_t camera, matting::StillBackdrop backdrop);
  /// Of the photograph's size, with what it leaves at the smaller one.
  void learn(std::size_t camera, matting::Plate plate, matting::StillBackdrop backdrop);
  /// The next instant has nothing to do with the last.
  void forget() { shadows_.seek_planes(); }
  /// On which shadows were found.
  int walls() const { return static_cast<int>(shadows_.walls().size()); }

  /// What a camera's stage tells of the picture that was looked at.
  struct View {
    std::optional<matting::StillBackdrop> lit;  ///< as this instant's light falls on it
    std::optional<matting::PlateWord> word;     ///< the plate's, of the photograph
    std::vector<float> odds;                    ///< log of how much likelier the subject is; empty: no word
    std::vector<float> in_constant_light;       ///< the same if light never changed; empty: as `odds`
    std::vector<std::uint8_t> shadow;           ///< not 0 where one falls; empty: nowhere
    std::vector<std::uint8_t> hidden;           ///< and where the subject may hide it, as others say

    bool may_hide_shadow(std::size_t pixel) const { return !hidden.empty() && hidden[pixel] != 0; }
    /// Whether the stage tells anything of the pixel.
    bool tells_of(std::size_t pixel) const { return lit && lit->knows(pixel) && !may_hide_shadow(pixel); }
  };

  /// `smaller`: of their sizes, empty where a camera has no picture. `pictures`: the photographs, or the
  /// same.
  void look(std::span<const Image> pictures, std::span<const Image> smaller, int threads);

  /// Asks others about changes of light and shadows. `grid`: of the last turn, where the subject is; asked
  /// anew. False where nothing is known of a floor under him, or too few cameras know their stages: nothing
  /// is changed.
  bool hear_others(recon::OccupancyGrid& grid, const recon::SharedView& shared, float subject_above,
                   int threads);

  const View& of(std::size_t camera) const { return views_[camera]; }

 private:
  bool knows_floor(const recon::OccupancyGrid& grid, const recon::SharedView& shared,
                   float subject_above) const;
  std::vector<Eigen::Hyperplane<double, 3>> off_floor_and_walls(double distance) const;

  struct Stage {
    std::optional<matting::StillBackdrop> backdrop;  // as it was learnt
    std::optional<matting::Plate> plate;             // of the empty stage, at the photograph's size
  };
  Rig rig_;
  std::vector<Eigen::Vector2i> sizes_;
  std::vector<Stage> stages_;
  std::vector<View> views_;
  matting::CastShadows shadows_;
};

}  // namespace floatstage::pipeline
