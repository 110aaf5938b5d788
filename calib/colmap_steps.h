#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/markerless.h"
#include "calib/scene_matching.h"

namespace floatstage::calib {

/// COLMAP's steps on a workspace: its program run with a time-out and a log. Private to calib.
class Colmap {
 public:
  Colmap(const MarkerlessOptions& options, std::filesystem::path workspace)
      : options_(options), log_(workspace / "colmap.log"), workspace_(std::move(workspace)) {}

  /// Whether the pictures are sound and the workspace is new or empty.
  Result<void> check_workspace(const std::vector<MarkerlessPicture>& pictures) const;
  /// That, and the pictures are copied into the workspace.
  Result<void> prepare(const std::vector<MarkerlessPicture>& pictures) const;
  /// Our keypoints and matches into the workspace's database, where COLMAP verifies them pair by pair.
  Result<void> import(const std::vector<MarkerlessPicture>& pictures,
                      const std::vector<SceneKeypoints>& keypoints,
                      const std::vector<SceneMatches>& matches) const;
  /// Models of the cameras, into `sparse`: lenses that are fixed stay, the others are solved for.
  Result<void> map(const std::vector<MarkerlessPicture>& pictures) const;
  /// One step of COLMAP; `advice` is what to do when it gives up.
  Result<void> run(const std::string& step, std::vector<std::string> arguments,
                   const std::string& advice) const;
  /// Writes a binary model as text, beside it.
  Result<void> to_text(const std::filesystem::path& model, const std::filesystem::path& written) const;

  const std::filesystem::path& workspace() const { return workspace_; }
  std::string path(const char* name) const { return (workspace_ / name).string(); }

 private:
  const MarkerlessOptions& options_;
  std::filesystem::path log_, workspace_;
};

/// Two pictures or more, serials usable and unique, sound models, pixels of their models' sizes; of lenses
/// that are not fixed no fisheye, and shared ones of one size. InvalidArgument otherwise.
Result<void> check_pictures(const std::vector<MarkerlessPicture>& pictures);

/// What a picture is called in COLMAP's database.
std::string image_name(const MarkerlessPicture& picture);

inline constexpr const char* kWeakScene =
    "too little is seen by neighbouring cameras together; put something textured on the stage, bring cameras "
    "closer together, or add "
    "pictures of a camera that is carried between them";

}  // namespace floatstage::calib
