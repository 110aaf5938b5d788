#include "pipeline/film.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <future>
#include <utility>

#include "core/log.h"
#include "core/text.h"
#include "pipeline/balance.h"
#include "pipeline/label.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"
#include "pipeline/subject.h"
#include "pipeline/take_fields.h"
#include "render/drawn_from.h"

namespace floatstage::pipeline {
namespace {

constexpr int kLeadIn = 8;  // pictures: a tenth of what was before is left at the usual memory

using Watch = std::chrono::steady_clock;
double since(Watch::time_point t) { return std::chrono::duration<double>(Watch::now() - t).count(); }

// Where in time the pictures of a film are.
class Clock {
 public:
  Clock(const FilmOptions& options, const CameraPath& path, double take_rate)
      : options_(options), path_(path), take_rate_(take_rate) {
    const double n = static_cast<double>(options.frames.size());
    const bool moving = options.frames.size() > 1 && take_rate > 0 && !path.has_take_times();
    const double seconds = options.seconds > 0 ? options.seconds : moving ? n / take_rate : path.duration();
    pictures_ = std::max(1, static_cast<int>(std::lround(seconds * options.frame_rate)));
    // A film as long as its path is the path, to the digit.
    if (std::abs(seconds - path.duration()) > kSameSeconds)
      stretch_ = path.duration() / (pictures_ / options.frame_rate);
  }

  double path_time(int picture) const { return picture / options_.frame_rate * stretch_; }
  // Which frame of the take each picture shows. What plays beside the path is not stretched with it.
  std::vector<int> frames() const {
    std::vector<int> shown;
    for (int p = 0; p < pictures_; ++p) {
      const double time = path_.has_take_times() ? path_time(p) : p / options_.frame_rate;
      shown.push_back(options_.frames[shown_at(path_, time, take_rate_, options_.frames)]);
    }
    return shown;
  }

 private:
  static constexpr double kSameSeconds = 1e-9;
  const FilmOptions& options_;
  const CameraPath& path_;
  const double take_rate_;
  int pictures_ = 1;
  double stretch_ = 1;
};

Result<void> check(const capture::TakeReader& take, const FilmOptions& options) {
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "a film of no frames");
  if (options.methods.empty())
    return fail(ErrorCode::InvalidArgument, "a film needs a method; see `floatstage render --help`");
  if (options.array.views < 1 || options.array.views > kMostViews || !(options.array.baseline > 0))
    return fail(ErrorCode::InvalidArgument, text("views are 1 to ", kMostViews,
                                                 " beside one another, a positive number of metres apart"));
  if (options.array.views > 1 && options.methods.size() > 1)
    return fail(ErrorCode::InvalidArgument,
                "several views are of one method: stereo pictures that stand beside others are none");
  if (options.block < 1) return fail(ErrorCode::InvalidArgument, "a film in blocks of no pictures");
  if (!(options.frame_rate > 0))
    return fail(ErrorCode::InvalidArgument, "the film's frame rate must be positive");
  for (int f : options.frames)
    if (f < 0 || f >= take.frame_count())
      return fail(ErrorCode::InvalidArgument,
                  text("frame ", f, " is not in the take, which has ", take.frame_count()));
  return render::check(options.renderer);
}

// Metres along the axis at which stereo pictures meet: at the subject, so that it stands in the screen.
double screen_distance(const View& view, const Eigen::AlignedBox3d& subject) {
  const double middle = subject.isEmpty() ? 0 : (view.view_from_world * subject.center()).z();
  return std::max(middle, view.near_plane);
}

Result<void> set_scene(const Rig& rig, const DrawnScene& instant, render::Scene& to) {
  if (const auto* whole = std::get_if<SceneFrame>(&instant)) return to.set(rig, *whole);
  const SceneParts& parts = std::get<SceneParts>(instant);
  std::vector<render::PictureTile> tiles;
  for (const PhotographPart& p : parts.photographs)
    tiles.push_back({p.camera, p.box.x, p.box.y, &p.photograph, &p.matte});
  return to.set(rig, parts.mesh, tiles);
}

// Decodes the next instant while the present one is drawn: of the photographs that its views are drawn from.
class SceneStream {
 public:
  SceneStream(capture::TakeReader& take, const FilmOptions& options, const std::vector<int>& schedule,
              const std::vector<std::vector<View>>& views)
      : rig_(take.rig()),
        options_(options),
        choosy_(options.renderer.output == render::RenderOutput::Color),
        loader_(take, options.suppress_spill),
        schedule_(schedule),
        views_(views),
        next_(load(0)) {}

  Result<DrawnScene> at(std::size_t picture) {
    Result<DrawnScene> scene = next_.get();
    if (const std::size_t later = end_of(picture); later < schedule_.size()) next_ = load(later);
    return scene;
  }

 private:
  std::size_t end_of(std::size_t picture) const {
    std::size_t later = picture + 1;
    while (later < schedule_.size() && schedule_[later] == schedule_[picture]) ++later;
    return later;
  }
  std::vector<View> views_from(std::size_t first) const {
    std::vector<View> views;
    for (std::size_t p = first; p < end_of(first); ++p)
      views.insert(views.end(), views_[p].begin(), views_[p].end());
    return views;
  }
  std::vector<std::vector<PixelBox>> drawn_in(const Mesh& mesh, const std::vector<View>& views) const {
    std::vector<std::vector<PixelBox>> parts(rig_.cameras.size());
    for (const View& view : views)
      for (const int camera : render::drawn_from(rig_, mesh, view, options_.renderer.cameras)) {
        std::vector<PixelBox>& of_one = parts[static_cast<std::size_t>(camera)];
        if (of_one.empty()) of_one = drawn_of(rig_.cameras[static_cast<std::size_t>(camera)], mesh, views);
      }
    return parts;
  }
  std::vector<PixelBox> drawn_of(const RigCamera& camera, const Mesh& mesh,
                                 const std::vector<View>& views) const {
    if (options_.renderer.back_end != render::BackEnd::Cpu)
      return {{0, 0, camera.model.width, camera.model.height}};
    std::vector<PixelBox> boxes;
    for (const std::string& method : options_.methods) {
      const std::vector<PixelBox> parts = render::parts_drawn_from(camera, mesh, views, method);
      boxes.insert(boxes.end(), parts.begin(), parts.end());
    }
    return boxes;
  }
  std::future<Result<DrawnScene>> load(std::size_t picture) {
    return std::async(std::launch::async, [this, picture]() -> Result<DrawnScene> {
      if (choosy_) {
        const std::vector<View> views = views_from(picture);
        return loader_.load_parts(schedule_[picture],
                                  [&](const Mesh& mesh) { return drawn_in(mesh, views); });
      }
      Result<SceneFrame> scene = loader_.load(schedule_[picture]);
      if (!scene) return forward(scene);
      return DrawnScene(std::move(*scene));
    });
  }

  const Rig& rig_;
  const FilmOptions& options_;
  const bool choosy_;  // pictures of weights and the like have colours by the number of cameras there are
  SceneLoader loader_;
  const std::vector<int>& schedule_;
  const std::vector<std::vector<View>>& views_;  // of a picture
  std::future<Result<DrawnScene>> next_;
};

using Renderers = std::vector<std::unique_ptr<render::ViewRenderer>>;

bool remembers_fields(const std::string& method) { return method == "floating"; }

// Whether picture p of those that are drawn is the first of a block (FilmOptions::block).
bool begins_anew(const std::vector<int>& drawn, std::size_t p, const FilmOptions& options) {
  return options.renderer.field_memory > 0 &&
         std::any_of(options.methods.begin(), options.methods.end(), remembers_fields) &&
         (p == 0 || drawn[p] != drawn[p - 1] + 1 || drawn[p] % options.block == 0);
}

// The first of the pictures before `picture` that are drawn for what they leave in its fields: of the same
// frame, for another scene's fields are forgotten.
int lead_in_of(const std::vector<int>& frames, int picture) {
  const auto frame_of = [&](int p) { return frames[static_cast<std::size_t>(p)]; };
  int first = picture;
  while (first > 0 && first > picture - kLeadIn && frame_of(first - 1) == frame_of(picture)) --first;
  return first;
}

Result<void> lead_in(const std::vector<std::vector<View>>& before, const render::Scene& scene,
                     const FilmOptions& options, const Renderers& renderers) {
  for (std::size_t i = 0; i < renderers.size(); ++i) {
    if (!remembers_fields(options.methods[i % options.methods.size()])) continue;
    renderers[i]->reset_history();
    for (const std::vector<View>& eyes : before) {
      const Result<render::RenderedView> drawn =
          renderers[i]->render(scene, eyes[i / options.methods.size()], options.renderer);
      if (!drawn) return forward(drawn);
    }
  }
  return {};
}

}  // namespace

Result<std::vector<int>> film_frames(const capture::TakeReader& take, const CameraPath& path,
                                     const FilmOptions& options) {
  if (Result<void> ok = check(take, options); !ok) return forward(ok);
  std::vector<int> frames = Clock(options, path, take.manifest().frame_rate).frames();
  for (const int picture : options.pictures)
    if (picture < 0 || static_cast<std::size_t>(picture) >= frames.size())
      return fail(ErrorCode::InvalidArgument,
                  text("picture ", picture, " is not in the film, which has ", frames.size()));
  return frames;
}

Result<Rig> film_rig(capture::TakeReader& take, const FilmOptions& options) {
  return options.balance ? rig_in_balance(take) : rig_with_colors(take);
}

Image over(const Image& rgba, const std::array<float, 3>& background) {
  Image rgb(rgba.width, rgba.height, 3);
  const std::size_t pixels = rgba.pixels.size() / 4;
  std::array<int, 3> under;
  for (std::size_t c = 0; c < 3; ++c) under[c] = static_cast<int>(std::lround(background[c] * 255.f));
  const std::uint8_t* from = rgba.pixels.data();
  std::uint8_t* to = rgb.pixels.data();
  for (std::size_t i = 0; i < pixels; ++i, from += 4, to += 3) {
    const int alpha = from[3];
    for (std::size_t c = 0; c < 3; ++c)
      to[c] = static_cast<std::uint8_t>(alpha == 0 ? under[c]
                                        : alpha == 255
                                            ? from[c]
                                            : (from[c] * alpha + under[c] * (255 - alpha) + 127) / 255);
  }
  return rgb;
}

Image side_by_side(const std::vector<Image>& pictures, const std::vector<std::string>& names) {
  int width = 0;
  for (const Image& p : pictures) width += p.width;
  Image sheet(width, pictures.front().height, 3);
  int left = 0;
  for (const Image& p : pictures) {
    for (int y = 0; y < p.height; ++y)
      std::memcpy(sheet.at(left, y), p.at(0, y), static_cast<std::size_t>(p.width) * 3);
    if (pictures.size() > 1)
      label(sheet, left, 0, p.height, names[static_cast<std::size_t>(&p - pictures.data())]);
    left += p.width;
  }
  return sheet;
}

Result<FilmReport> render_film(capture::TakeReader& take, const CameraPath& path, const FilmOptions& options,
                               const std::function<Result<void>(FilmPicture)>& visit) {
  const Result<std::vector<int>> whole = film_frames(take, path, options);
  if (!whole) return forward(whole);
  const Watch::time_point begin = Watch::now();
  Renderers renderers;
  for (std::size_t i = 0; i < options.methods.size() * static_cast<std::size_t>(options.array.views); ++i) {
    const std::string& method = options.methods[i % options.methods.size()];
    Result<std::unique_ptr<render::ViewRenderer>> r =
        render::make_renderer(method, options.renderer.back_end);
    if (!r) return forward(r);
    renderers.push_back(std::move(*r));
  }
  Subject subject;
  if (options.subject && (options.track || !path.follows())) {
    subject.box = *options.subject;
    subject.track = options.track.value_or(SubjectTrack());
  } else {
    Result<Subject> found = find_subject(take);
    if (!found) return forward(found);
    subject = std::move(*found);
  }
  const Eigen::AlignedBox3d& box = subject.box;
  const Result<Rig> rig = options.rig ? Result<Rig>(*options.rig) : film_rig(take, options);
  if (!rig) return forward(rig);

  const Clock clock(options, path, take.manifest().frame_rate);
  std::vector<int> drawn_pictures = options.pictures, frames;
  for (std::size_t p = 0; options.pictures.empty() && p < whole->size(); ++p)
    drawn_pictures.push_back(static_cast<int>(p));
  const auto middle_of = [&](int picture) {
    const PathKey key = sample(path, clock.path_time(picture), subject.track);
    return view_of(key, options.width, options.height, box);
  };
  const auto eyes_of = [&](const View& middle) {
    return views_of(middle, options.array, screen_distance(middle, box));
  };
  std::vector<View> middles;
  std::vector<std::vector<View>> views, needed;  // of a picture; and with those that are drawn for its sake
  std::vector<std::vector<std::vector<View>>> led_in;
  for (std::size_t p = 0; p < drawn_pictures.size(); ++p) {
    const int picture = drawn_pictures[p];
    middles.push_back(middle_of(picture));
    views.push_back(eyes_of(middles.back()));
    frames.push_back((*whole)[static_cast<std::size_t>(picture)]);
    led_in.emplace_back();
    needed.push_back(views.back());
    if (!begins_anew(drawn_pictures, p, options)) continue;
    for (int before = lead_in_of(*whole, picture); before < picture; ++before) {
      led_in.back().push_back(eyes_of(middle_of(before)));
      needed.back().insert(needed.back().end(), led_in.back().back().begin(), led_in.back().back().end());
    }
  }
  const bool with_fields =
      std::find(options.methods.begin(), options.methods.end(), kFieldMethod) != options.methods.end();
  SceneStream scenes(take, options, frames, needed);
  render::Scene drawn;
  FilmReport report;
  std::optional<render::StageTimes> times;
  if (options.time_stages && options.renderer.back_end == render::BackEnd::Gl) times.emplace();
  std::size_t without_camera = 0;
  ProgressPart progress(options.progress, "pictures", frames.size());
  for (std::size_t p = 0; p < frames.size(); ++p) {
    if (is_cancelled(options.progress)) return cancelled();
    auto in_frame = [&](const Error& e) { return fail(e.code, text("frame ", frames[p], ": ", e.message)); };
    const Watch::time_point drawing = Watch::now();
    if (p == 0 || frames[p] != frames[p - 1]) {
      Result<DrawnScene> scene = scenes.at(p);
      if (!scene) return forward(scene);
      if (Result<void> ok = set_scene(*rig, *scene, drawn); !ok) return in_frame(ok.error());
      if (with_fields)
        if (Result<void> ok = give_fields(take.layout(), *rig, frames[p], drawn); !ok)
          return in_frame(ok.error());
    }
    if (begins_anew(drawn_pictures, p, options))
      if (Result<void> ok = lead_in(led_in[p], drawn, options, renderers); !ok) return in_frame(ok.error());
    FilmPicture picture{drawn_pictures[p], frames[p], middles[p], {}};
    render::SeenPixels seen;
    for (std::size_t i = 0; i < renderers.size(); ++i) {
      const View& view = views[p][i / options.methods.size()];
      Result<render::RenderedView> rendered = renderers[i]->render(drawn, view, options.renderer);
      if (!rendered) return in_frame(rendered.error());
      render::StageTimes::enter("reading back");
      without_camera += i == 0 && render::lacks_shown_camera(*rendered, options.renderer);
      picture.renders.push_back(render::download(*rendered));
      const render::SeenPixels of_one = render::seen_pixels(*rendered);
      seen.shown += of_one.shown, seen.seen += of_one.seen;
    }
    report.sight.add(drawn_pictures[p], seen);
    if (times) render::add(times->take(), report.stages);
    report.render_seconds += since(drawing);
    if (Result<void> ok = visit(std::move(picture)); !ok) return forward(ok);
    ++report.pictures;
    progress.advance();
  }
  if (without_camera > 0)
    log::warning(text(without_camera, " of ", report.pictures,
                      " pictures show nothing: their views are not drawn from a camera that was to be shown; "
                      "--blend takes more in"));
  if (const std::optional<std::string> doubt = report.sight.doubt()) log::warning(*doubt);
  report.seconds = since(begin);
  return report;
}

}  // namespace floatstage::pipeline
