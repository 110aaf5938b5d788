#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/camera_path.h"
#include "pipeline/film_sight.h"
#include "pipeline/progress.h"
#include "pipeline/view_array.h"
#include "render/renderer.h"
#include "render/stage_times.h"

namespace floatstage::pipeline {

struct FilmOptions {
  int width = 640, height = 480;  ///< of one picture
  double frame_rate = 25;         ///< of the film
  /// Length; 0: the path's when it says what of the take is shown, else the take's own, or the path's when
  /// the take is one instant. A path of another length is stretched to it.
  double seconds = 0;
  std::vector<int> frames;  ///< frames of the take to play, in order; begun again when the film is longer
  std::vector<std::string> methods;  ///< renderers, each draws every picture
  ViewArray array = {};              ///< several eyes beside one another, of one method
  bool suppress_spill = true;
  bool balance = false;                             ///< cameras' colours are brought to one another
  std::optional<Eigen::AlignedBox3d> subject = {};  ///< find_subject() of the take, where it is known
  std::optional<SubjectTrack> track = {};           ///< of the subject, where it is known
  std::optional<Rig> rig = {};                      ///< film_rig() of the take, where it is known
  /// Which pictures of the film are drawn, indices in rising order; empty: all.
  std::vector<int> pictures = {};
  /// Fields are remembered (RendererOptions::field_memory) for so many pictures, and begin anew with a few
  /// that are drawn for their sake: a film that is made in parts of this size is the same whoever makes them.
  int block = 50;
  render::RendererOptions renderer;
  bool time_stages = false;      ///< OpenGL: what a picture's stages take; waits for each picture
  Progress* progress = nullptr;  ///< null: unwatched
};

/// One picture of a film as it comes off the renderers.
struct FilmPicture {
  int index = 0;  ///< in the film
  int frame = 0;  ///< of the take
  View view;
  std::vector<Image> renders;  ///< RGBA, one a method, or of one method one an eye
};

struct FilmReport {
  int pictures = 0;
  double seconds = 0;                          ///< that it took
  double render_seconds = 0;                   ///< of it in the renderers
  std::vector<render::StageTime> stages = {};  ///< FilmOptions::time_stages: sums over all pictures
  FilmSight sight = {};
};

/// Which frame of the take each picture of the whole film shows. InvalidArgument for options that make no
/// film.
Result<std::vector<int>> film_frames(const capture::TakeReader& take, const CameraPath& path,
                                     const FilmOptions& options);

/// The take's rig with the colours that a film of these options is drawn with. Errors: a photograph's.
Result<Rig> film_rig(capture::TakeReader& take, const FilmOptions& options);

/// Walks the virtual camera along `path` while the take plays and hands each picture to `visit`, in order, on
/// the calling thread. The renderer's back-end must be open (open_back_end()). Stops at the first error of
/// `visit`. Without motion blur a picture does not depend on which others are drawn, as long as its block is
/// drawn from its beginning.
Result<FilmReport> render_film(capture::TakeReader& take, const CameraPath& path, const FilmOptions& options,
                               const std::function<Result<void>(FilmPicture)>& visit);

/// RGBA over a background colour (0…1).
Image over(const Image& rgba, const std::array<float, 3>& background);

/// RGB pictures of one height, left to right, each with its name in the upper left corner where there are
/// several.
Image side_by_side(const std::vector<Image>& pictures, const std::vector<std::string>& names);

}  // namespace floatstage::pipeline
