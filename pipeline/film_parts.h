#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/sound/film_sound.h"
#include "core/claim.h"
#include "core/result.h"
#include "pipeline/picture_sink.h"

namespace floatstage::pipeline {

/// What the pictures of a folder are: PNG, alpha straight; or OpenEXR in linear light, colours multiplied by
/// their opacity.
enum class Stills { Png, Exr };

/// A film on its way to disk.
struct FilmShape {
  int width = 0, height = 0;
  double frame_rate = 0;
  int pictures = 0;
  bool in_one = false;          ///< it cannot be made in parts: a picture depends on those before it
  bool with_opacity = false;    ///< see check_film_name()
  Stills stills = Stills::Png;  ///< where it is a folder
  /// Of a part; the last one takes what is left over. Two seconds of a usual film: what a kill costs, against
  /// a picture coded whole in each.
  int part_pictures = 50;
};

/// A film that is made in parts, so that a run that was stopped goes on, and that several
/// machines work on one: <out>.parts/ holds film.json (what the film is made from), a file a part
/// (000050.mp4; of a folder of stills pictures/), and beside it its record, written when the part is whole
/// (000050.json: what its pictures were drawn from, and SHA-256 of its files). join() makes the film of them;
/// it is always made so, so that it has the same bytes whoever made its parts, and when
/// (docs/adr/0255-films-are-made-in-parts.md).
class FilmParts {
 public:
  struct Part {
    int first = 0, count = 0;  ///< pictures of the film
  };

  /// Who makes the film: one run alone, which joins it; or one of several, each with pictures of its own.
  enum class Use { Alone, Shared };

  /// `made_from`: hash of what is the same for all pictures. Parts that were made from something else are
  /// removed when we are alone, and that is said; else they are refused. AlreadyExists when `out` is there or
  /// is being made by a run alone; InvalidArgument for a name that says no kind of film, or
  /// a video for EXRs; Io.
  static Result<std::unique_ptr<FilmParts>> open(const std::filesystem::path& out, const FilmShape& shape,
                                                 const std::string& made_from, Use use);
  /// Removes the folder again when we are alone and there is no part in it.
  ~FilmParts();

  /// The parts of such a film, in order.
  static std::vector<Part> divide(const FilmShape& shape);
  const std::vector<Part>& parts() const { return parts_; }
  /// Whether the part is there as it was written, and was drawn from these `inputs`, a hash.
  bool is_done(std::size_t part, const std::string& inputs) const;
  /// Takes the part's pictures; its finish() makes it one that is done. AlreadyExists when another run makes
  /// it at this moment; Io.
  Result<std::unique_ptr<PictureSink>> begin(std::size_t part, const std::string& inputs);
  /// Puts the film into its place, with `sound` when it is a video and there is some, and removes its parts.
  /// Every part is done. AlreadyExists, Io, errors of the sound.
  Result<void> join(const capture::FilmSound* sound = nullptr);

 private:
  FilmParts(const std::filesystem::path& out, const FilmShape& shape, Use use);
  Result<void> settle(const std::string& made_from);
  void remove_parts();
  void remove_folder();
  std::filesystem::path file(std::size_t part, const char* extension) const;
  std::filesystem::path picture(int index) const;
  std::vector<std::filesystem::path> files(std::size_t part) const;
  bool is_video() const { return !out_.extension().empty(); }
  const char* part_extension() const { return shape_.with_opacity ? ".mov" : ".mp4"; }

  const std::filesystem::path out_, folder_;
  const FilmShape shape_;
  const Use use_;
  std::vector<Part> parts_;
  std::optional<Claim> claim_;  // of a run alone
};

}  // namespace floatstage::pipeline
