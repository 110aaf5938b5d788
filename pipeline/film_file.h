#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/camera_path.h"
#include "pipeline/film.h"
#include "pipeline/film_parts.h"

namespace floatstage::pipeline {

struct FilmFileOptions {
  std::filesystem::path out;    ///< .mp4, .mkv, .mov, or a folder for stills; see check_film_name()
  std::string drawn_by;         ///< the program and what it draws with; see hash_of_film()
  bool with_opacity = false;    ///< of the one renderer, straight, in the place of the background
  Stills stills = Stills::Png;  ///< of a folder
  /// Only the parts with these pictures of the film, which is then not joined: several runs, on several
  /// machines, make one film so. Empty: all, and the film is put into its place.
  std::vector<int> pictures = {};
  int part_pictures = FilmShape{}.part_pictures;
  bool sound = true;             ///< videos are heard, where the take has sound (film_sound.h)
  std::string sound_track = {};  ///< of several; empty: the first
};

struct FilmFileReport {
  FilmReport film;          ///< of what was drawn now
  int pictures = 0;         ///< of the whole film
  int kept = 0;             ///< pictures that were there from before
  int parts = 0, done = 0;  ///< of the film, now
  std::string sound = {};   ///< the track that is heard in it; empty: none
  double sound_seconds = 0;
};

/// Renders a film into a file, in parts (FilmParts): goes on where a run that was stopped, by whatever, left
/// off, and keeps no part whose photographs, mattes, meshes or options have changed since. `options.pictures`
/// is ours to choose; renderers' pictures stand side by side over the background. With motion blur, where a
/// picture depends on those before it, there is one part. Errors: those of render_film(), FilmParts;
/// Cancelled keeps the parts that are whole.
Result<FilmFileReport> render_film_file(capture::TakeReader& take, const CameraPath& path,
                                        const FilmOptions& options, const FilmFileOptions& file);

}  // namespace floatstage::pipeline
