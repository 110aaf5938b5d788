#include "apps/film.h"

#include <chrono>
#include <cmath>
#include <future>
#include <iomanip>

#include "apps/interrupt.h"
#include "apps/picture_sink.h"
#include "apps/progress.h"
#include "apps/scene_loader.h"
#include "core/text.h"

namespace floatstage {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

// Which frame of the take each picture of the film shows.
std::vector<int> schedule(const FilmOptions& options, double take_rate, double path_seconds) {
  const double n = static_cast<double>(options.frames.size());
  const bool moving = options.frames.size() > 1 && take_rate > 0;
  const double seconds = options.seconds > 0 ? options.seconds : moving ? n / take_rate : path_seconds;
  const int pictures = std::max(1, static_cast<int>(std::lround(seconds * options.frame_rate)));
  std::vector<int> frames(static_cast<std::size_t>(pictures), options.frames.front());
  if (!moving) return frames;
  for (std::size_t p = 0; p < frames.size(); ++p) {
    const auto played = static_cast<std::size_t>(static_cast<double>(p) / options.frame_rate * take_rate + 1e-6);
    frames[p] = options.frames[played % options.frames.size()];
  }
  return frames;
}

void copy_over(const Image& rgba, const std::array<float, 3>& background, Image& out, int left) {
  for (int y = 0; y < rgba.height; ++y) {
    for (int x = 0; x < rgba.width; ++x) {
      const std::uint8_t* in = rgba.at(x, y);
      std::uint8_t* to = out.at(left + x, y);
      for (int c = 0; c < 3; ++c) {
        const float under = background[static_cast<std::size_t>(c)] * 255.f, a = static_cast<float>(in[3]) / 255.f;
        to[c] = static_cast<std::uint8_t>(std::lround(static_cast<float>(in[c]) * a + under * (1 - a)));
      }
    }
  }
}

Result<void> check(const TakeReader& take, const FilmOptions& options) {
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "a film of no frames");
  if (options.methods.empty()) return fail(ErrorCode::InvalidArgument, "a film needs a method; see `floatstage render --help`");
  if (!(options.frame_rate > 0)) return fail(ErrorCode::InvalidArgument, "the film's frame rate must be positive");
  for (int f : options.frames)
    if (f < 0 || f >= take.frame_count()) return fail(ErrorCode::InvalidArgument, text("frame ", f, " is not in the take, which has ", take.frame_count()));
  return floatstage::check(options.renderer);
}

}  // namespace

Result<FilmReport> render_film(TakeReader& take, const CameraPath& path, const FilmOptions& options) {
  if (Result<void> ok = check(take, options); !ok) return forward(ok);
  const Clock::time_point begin = Clock::now();
  std::vector<std::unique_ptr<ViewRenderer>> renderers;
  for (const std::string& method : options.methods) {
    Result<std::unique_ptr<ViewRenderer>> r = make_renderer(method);
    if (!r) return forward(r);
    renderers.push_back(std::move(*r));
  }
  Result<Eigen::AlignedBox3d> box = subject_box(take);
  if (!box) return forward(box);

  const int columns = static_cast<int>(renderers.size());
  Result<std::unique_ptr<PictureSink>> sink = open_picture_sink(options.out, options.width * columns, options.height, options.frame_rate);
  if (!sink) return forward(sink);

  const std::vector<int> frames = schedule(options, take.manifest().frame_rate, path.duration());
  const double film_seconds = static_cast<double>(frames.size()) / options.frame_rate;
  auto load = [&](int frame) {
    return std::async(std::launch::async, [&take, &options, frame] { return load_scene(take, frame, options.suppress_spill); });
  };
  // The next instant is decoded while this one is drawn.
  std::future<Result<SceneFrame>> next = load(frames.front());
  SceneTextures textures;
  FilmReport report;
  Progress progress("pictures", frames.size());
  for (std::size_t p = 0; p < frames.size(); ++p) {
    if (interrupted()) return cancelled();
    const bool new_instant = p == 0 || frames[p] != frames[p - 1];
    if (new_instant) {
      Result<SceneFrame> scene = next.get();
      if (!scene) return forward(scene);
      std::size_t q = p + 1;
      while (q < frames.size() && frames[q] == frames[p]) ++q;
      if (q < frames.size()) next = load(frames[q]);
      if (Result<void> ok = textures.upload(take.rig(), *scene); !ok) return fail(ok.error().code, text("frame ", frames[p], ": ", ok.error().message));
    }
    const double film_time = static_cast<double>(p) / options.frame_rate;
    const View view = view_of(sample(path, film_time / film_seconds * path.duration()), options.width, options.height, *box);
    Image picture(options.width * columns, options.height, 3);
    for (int c = 0; c < columns; ++c) {
      const Clock::time_point drawing = Clock::now();
      Result<RenderedView> rendered = renderers[static_cast<std::size_t>(c)]->render(textures, view, options.renderer);
      if (!rendered) return fail(rendered.error().code, text("frame ", frames[p], ": ", rendered.error().message));
      copy_over(download(*rendered), options.renderer.background, picture, c * options.width);
      report.render_seconds += since(drawing);
    }
    if (Result<void> ok = (*sink)->write(picture); !ok) return forward(ok);
    ++report.pictures;
    progress.advance();
  }
  if (Result<void> ok = (*sink)->finish(); !ok) return forward(ok);
  report.seconds = since(begin);
  return report;
}

}  // namespace floatstage
