#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/result.h"
#include "detail/photo_relations.h"

namespace floatstage::detail {

/// A photograph with what it is a detail of.
struct GraphPhoto {
  Photo photo;
  int parent = -1;  ///< index; -1: of nothing
  double zoom = 0;  ///< linear: its pixels in one of the parent's; 0 without a parent
  /// Pixels of this photograph to the parent's, corners at whole numbers; identity without a parent.
  Eigen::Matrix3d parent_from_child = Eigen::Matrix3d::Identity();
  int inliers = 0;
  double rms = 0;  ///< of the inliers, px of the parent
};

/// Why one photograph is not the child of another; an end of a sentence.
struct Refusal {
  std::string child, parent, why;
};

/// Which photographs show details of which: trees, each from a wide photograph to ever closer ones
/// (thesis 4.2).
struct PhotoGraph {
  std::filesystem::path folder;
  std::vector<GraphPhoto> photos;  ///< by name
  int root = -1;                   ///< whose tree is worked on
  std::vector<Refusal> refused;    ///< every ordered pair that is no edge, by child and parent
  std::vector<UnreadPhoto> unread;

  /// The photographs below one, each after its parent.
  std::vector<int> descendants(int photo) const;
};

/// Chooses every child's parent: of those that contain it the one in which it is largest (Eq. 4.1). A child
/// that has no more pixels than its parent has there is removed and its children go to that parent; copies of
/// one photograph are one; what would close a circle is refused. `root`: a photograph's name; empty: that
/// with the most below it. InvalidArgument when there is no photograph of that name.
Result<PhotoGraph> choose_parents(const PhotoRelations& relations, const std::string& root);

/// relate_photos() and choose_parents().
struct GraphOptions {
  RelationOptions relations;
  std::string root;
};
Result<PhotoGraph> build_photo_graph(const std::filesystem::path& folder, const GraphOptions& options);

}  // namespace floatstage::detail
