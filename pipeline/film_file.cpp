#include "pipeline/film_file.h"

#include <algorithm>
#include <future>
#include <utility>

#include "core/text.h"
#include "pipeline/film_inputs.h"
#include "pipeline/film_sound.h"
#include "pipeline/subject.h"

namespace floatstage::pipeline {
namespace {

// A part that is to be drawn.
struct Todo {
  std::size_t part = 0;
  std::string inputs;
};

bool holds_any(const FilmParts::Part& part, const std::vector<int>& pictures) {
  return pictures.empty() || std::any_of(pictures.begin(), pictures.end(), [&](int picture) {
           return picture >= part.first && picture < part.first + part.count;
         });
}

Result<FilmOptions> completed(capture::TakeReader& take, const CameraPath& path, FilmOptions options) {
  if (!options.subject || (path.follows() && !options.track)) {
    Result<Subject> subject = find_subject(take);
    if (!subject) return forward(subject);
    options.subject = subject->box;
    if (path.follows()) options.track = std::move(subject->track);
  }
  if (!options.rig) {
    Result<Rig> rig = film_rig(take, options);
    if (!rig) return forward(rig);
    options.rig = std::move(*rig);
  }
  return options;
}

// Hands pictures to the part that they belong to.
class PartWriter {
 public:
  PartWriter(FilmParts& parts, const std::vector<Todo>& todo) : parts_(parts), todo_(todo) {}

  Result<void> write(int picture, const Image& drawn) {
    const FilmParts::Part& part = parts_.parts()[todo_[at_].part];
    if (picture == part.first) {
      Result<std::unique_ptr<PictureSink>> sink = parts_.begin(todo_[at_].part, todo_[at_].inputs);
      if (!sink) return forward(sink);
      sink_ = std::move(*sink);
    }
    if (Result<void> ok = sink_->write(drawn); !ok) return ok;
    if (picture + 1 < part.first + part.count) return {};
    if (Result<void> ok = sink_->finish(); !ok) return ok;
    sink_.reset();
    ++at_;
    return {};
  }

 private:
  FilmParts& parts_;
  const std::vector<Todo>& todo_;
  std::size_t at_ = 0;
  std::unique_ptr<PictureSink> sink_;
};

// Makes the film's pictures of what was drawn and writes them, each while the next one is drawn.
class WriterBehind {
 public:
  WriterBehind(FilmParts& parts, const std::vector<Todo>& todo, const FilmOptions& options, bool with_opacity)
      : writer_(parts, todo), options_(options), with_opacity_(with_opacity) {}

  /// The error, if any, is that of the picture before.
  Result<void> write(FilmPicture picture) {
    if (Result<void> ok = wait(); !ok) return ok;
    last_ = std::async(std::launch::async, [this, drawn = std::move(picture)] {
      return writer_.write(drawn.index, shown(drawn.renders));
    });
    return {};
  }
  Result<void> wait() { return last_.valid() ? last_.get() : Result<void>(); }

 private:
  Image shown(const std::vector<Image>& renders) const {
    if (with_opacity_) return tiled(renders, options_.array);
    std::vector<Image> pictures;
    for (const Image& rgba : renders) pictures.push_back(over(rgba, options_.renderer.background));
    return options_.array.views > 1 ? tiled(pictures, options_.array)
                                    : side_by_side(pictures, options_.methods);
  }

  PartWriter writer_;
  const FilmOptions& options_;
  const bool with_opacity_;
  std::future<Result<void>> last_;  // ends before what it writes with
};

// What of the film is to be drawn, in order; counts what is there.
Result<std::vector<Todo>> find_todo(const capture::TakeReader& take, const FilmParts& parts,
                                    const std::vector<int>& frames, const std::vector<int>& pictures,
                                    FilmFileReport& report) {
  std::vector<Todo> todo;
  for (std::size_t i = 0; i < parts.parts().size(); ++i) {
    const FilmParts::Part& part = parts.parts()[i];
    const auto first = frames.begin() + part.first;
    Result<std::string> inputs = hash_of_scenes(take, {first, first + part.count});
    if (!inputs) return forward(inputs);
    if (parts.is_done(i, *inputs)) {
      ++report.done;
      if (holds_any(part, pictures)) report.kept += part.count;
    } else if (holds_any(part, pictures)) {
      todo.push_back({i, std::move(*inputs)});
    }
  }
  return todo;
}

FilmShape shape_of(const FilmOptions& options, int pictures, const FilmFileOptions& file) {
  const int across = columns_of(options.array) * static_cast<int>(options.methods.size());
  return {.width = options.width * across,
          .height = options.height * rows_of(options.array),
          .frame_rate = options.frame_rate,
          .pictures = pictures,
          .in_one = options.renderer.motion_blur > 0,
          .with_opacity = file.with_opacity,
          .stills = file.stills,
          .part_pictures = file.part_pictures};
}

}  // namespace

Result<FilmFileReport> render_film_file(capture::TakeReader& take, const CameraPath& path,
                                        const FilmOptions& wanted, const FilmFileOptions& file) {
  if (file.with_opacity && wanted.methods.size() > 1)
    return fail(ErrorCode::InvalidArgument, "opacity is of one method");
  Result<FilmOptions> options = completed(take, path, wanted);
  if (!options) return forward(options);
  options->pictures = file.pictures;
  options->block = file.part_pictures;
  const Result<std::vector<int>> frames = film_frames(take, path, *options);
  if (!frames) return forward(frames);
  const Result<std::string> made_from =
      hash_of_film(take, path, *options,
                   text(file.drawn_by, file.with_opacity ? " with opacity" : "",
                        file.stills == Stills::Exr ? " as EXR" : "", " in ", file.part_pictures));
  if (!made_from) return forward(made_from);
  const FilmShape shape = shape_of(*options, static_cast<int>(frames->size()), file);
  Result<std::unique_ptr<FilmParts>> parts = FilmParts::open(
      file.out, shape, *made_from, file.pictures.empty() ? FilmParts::Use::Alone : FilmParts::Use::Shared);
  if (!parts) return forward(parts);
  // Before anything is drawn: what cannot be heard is said at once.
  Result<std::unique_ptr<FilmSounds>> sounds = std::unique_ptr<FilmSounds>();
  if (file.sound && file.out.has_extension())
    sounds = FilmSounds::open(take, *frames, options->frame_rate, file.sound_track);
  if (!sounds)
    return fail(sounds.error().code, text(sounds.error().message, "; leave it out with --no-sound"));
  FilmFileReport report{.film = {}, .pictures = shape.pictures};
  report.parts = static_cast<int>((*parts)->parts().size());
  const Result<std::vector<Todo>> todo = find_todo(take, **parts, *frames, file.pictures, report);
  if (!todo) return forward(todo);

  options->pictures.clear();
  for (const Todo& one : *todo)
    for (int i = 0; i < (*parts)->parts()[one.part].count; ++i)
      options->pictures.push_back((*parts)->parts()[one.part].first + i);
  if (!todo->empty()) {
    WriterBehind writer(**parts, *todo, *options, file.with_opacity);
    const Result<FilmReport> drawn = render_film(
        take, path, *options, [&](FilmPicture picture) { return writer.write(std::move(picture)); });
    const Result<void> written = writer.wait();
    if (!drawn) return forward(drawn);
    if (!written) return forward(written);
    report.film = *drawn;
    report.done += static_cast<int>(todo->size());
  }
  if (!file.pictures.empty()) return report;
  if (Result<void> ok = (*parts)->join(*sounds ? &(*sounds)->sound() : nullptr); !ok) return forward(ok);
  if (*sounds) report.sound = (*sounds)->track();
  if (*sounds) report.sound_seconds = (*sounds)->seconds();
  return report;
}

}  // namespace floatstage::pipeline
