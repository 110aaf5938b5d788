#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "core/rig.h"
#include "matting/keyers/plate.h"

namespace floatstage::pipeline {

struct ConsistentOptions {
  int working_pixels = 100'000;  ///< the turns are made at about so many a picture; 2'000 … 1'000'000
  int voxels = 500'000;          ///< space is asked at about so many places; 10'000 … 10'000'000
  int turns = 6;                 ///< at most, where nothing is known yet; 1 … 50
  int later_turns = 2;           ///< likewise of an instant that follows another; 1 … 50
  double smooth = 3;             ///< of a step of the outline, against log-likelihoods; 0 … 100
  bool refine = true;            ///< closed form around the edge at full size; else what was cut, enlarged
  int threads = 0;               ///< 0: one per core; the result is the same at any number

  Result<void> check() const;
};

/// How one camera came out, measured at the turns' size.
struct ConsistentView {
  bool pictured = false;  ///< there was a photograph; else all else is 0
  double subject = 0;     ///< share of the picture
  double sure = 0;        ///< share of what it or the others hold for subject that its colours bear out
  double border = 0;      ///< share of the picture's border that is subject
  double missing = 0;     ///< share of what the others clearly see that it lacks
  double surplus = 0;     ///< share of its subject that the others deny
};

struct ConsistentMattes {
  std::vector<Image> mattes;          ///< one channel, of the photographs' sizes; empty without a photograph
  std::vector<ConsistentView> views;  ///< in rig order
  /// What a person should know before using them, a sentence each, with the cameras' names.
  std::vector<std::string> remarks;
  bool trusted = true;  ///< false where a remark says that mattes are probably wrong
  /// Those remarks without figures, and the cameras that they name, in rig order; none: all.
  std::vector<std::pair<std::string, std::vector<int>>> wrong = {};
  int turns = 0;
};

/// Mattes of all cameras of one instant without a key: the subject is what lies around the point that the
/// cameras look at and is consistent across their pictures.
///
/// In turns, colours of the subject (shared by all cameras) and of each camera's backdrop are learnt from the
/// last cut, all cameras are asked about space (recon/occupancy.h), and every picture is cut anew between its
/// colours and what the others say of it: the scheme of N. Campbell, G. Vogiatzis, C. Hernández, R. Cipolla,
/// "Automatic 3D Object Segmentation in Multiple Views using Volumetric Graph-Cuts" (2010), with a soft
/// occupancy grid in place of the volumetric cut, as W. Lee, W. Woo, E. Boyer, "Silhouette Segmentation in
/// Multiple Views" (2011), go to and fro between silhouettes and their hull. It begins with what edges
/// separate from the picture's border. Closed form then solves the edges at full size.
///
/// State is what the last instant left: colours and where the subject was. Not for two threads at once.
class ConsistentMatting {
 public:
  /// Errors: those of check() and of recon::shared_view().
  static Result<ConsistentMatting> create(const Rig& rig, const ConsistentOptions& options);
  ConsistentMatting(ConsistentMatting&&) noexcept;
  ConsistentMatting& operator=(ConsistentMatting&&) noexcept;
  ~ConsistentMatting();

  /// Pixels of a camera's picture in the turns.
  Eigen::Vector2i working_size(int camera) const;
  /// What a still camera saw at other instants, at least two, of its working size: what moves then counts as
  /// more likely subject. `subjects`: empty, or where the subject is or may be in each of them (not 0): what
  /// was never seen without him is not known, and says nothing. Errors: InvalidArgument.
  Result<void> learn_backdrop(int camera, const std::vector<Image>& pictures,
                              const std::vector<Image>& subjects = {});
  /// What a still camera sees of the empty stage, of its photographs' size: surer than what is learnt of
  /// other instants, and in its place. Edges, too, are then found where something stands before it. Errors:
  /// InvalidArgument.
  Result<void> learn_empty_stage(int camera, matting::Plate plate);
  /// How far from what a cut holds for subject a place is still no backdrop.
  enum class Margin {
    Bridged,  ///< some pixels off it, and what it surrounds, as shorts between a trunk and legs
    Close,    ///< some pixels off it
  };
  /// Where the subject is or may be at an instant: of each camera a mask (255) of its working size, as are
  /// `pictures`; empty for those without one. The next instant begins with what is left, as after matte().
  /// Errors as of matte().
  Result<std::vector<Image>> surroundings(std::span<const Image> pictures, Margin margin,
                                          const std::function<bool()>& go_on = nullptr);
  /// The next instant begins as if it were the first.
  void forget();
  /// Walls on which shadows were found, which are none of the subject (matting/cast_shadows.h).
  int walls() const;

  /// `pictures`: of each camera an RGB photograph of its size, or empty. `said`: empty, or of each camera
  /// what a person marked: one channel of the photograph's size (0 background, 255 subject, else unknown) or
  /// empty. `go_on` may stop the work between two turns (Cancelled). Errors: InvalidArgument for pictures
  /// that do not fit, BadData when fewer than two cameras have one.
  Result<ConsistentMattes> matte(std::span<const Image> pictures, std::span<const Image> said = {},
                                 const std::function<bool()>& go_on = nullptr);

  /// Mattes of keys that may each be wrong in places, weighed against the colours and against what all
  /// cameras together see: the same turns, begun with the keys, whose word counts in each. `keys[i]`: one
  /// channel of the photograph's size, or empty: that camera is asked nothing and gets nothing. Of the mattes
  /// each is its key, byte for byte, but where corrected_key() changes it. Remarks, views and `trusted` are
  /// those of the cuts; where they are not to be trusted neither are the corrections. Leaves the state as
  /// forget() does. Errors as of matte().
  Result<ConsistentMattes> reconcile(std::span<const Image> pictures, std::span<const Image> keys);

 private:
  struct Impl;
  explicit ConsistentMatting(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::pipeline
