#include "studio/node/camera_view_maker.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/log.h"
#include "core/text.h"
#include "matting/keyers/empty_stage.h"
#include "matting/keyers/plate_corrected_keyer.h"

namespace floatstage::studio {
namespace {

constexpr int kMostShrink = 8;

class Stopwatch {
 public:
  /// Milliseconds since the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The camera that would have taken the shrunk picture.
CameraModel shrunk(CameraModel model, int factor) {
  model.width = (model.width + factor - 1) / factor;
  model.height = (model.height + factor - 1) / factor;
  for (double* v : {&model.fx, &model.fy, &model.cx, &model.cy, &model.skew}) *v /= factor;
  return model;
}

matting::CleanupOptions shrunk(matting::CleanupOptions cleanup, int factor) {
  cleanup.close_radius /= factor;
  cleanup.thin_radius /= factor;
  return cleanup;
}

/// Blames the camera by its name.
Unexpected blame(const std::string& serial, const Error& error) {
  return fail(error.code, text("camera '", serial, "': ", error.message));
}

}  // namespace

Result<void> check(const NodeQuality& quality) {
  if (quality.shrink < 1 || quality.shrink > kMostShrink)
    return fail(
        ErrorCode::InvalidArgument,
        text("keying at 1/", quality.shrink, " of the picture's size; 1 to ", kMostShrink, " are possible"));
  if (!(quality.tolerance >= 0 && quality.tolerance <= 16))
    return fail(ErrorCode::InvalidArgument,
                text("a contour tolerance of ", quality.tolerance, " px is not between 0 and 16"));
  if (!(quality.smallest >= 0 && quality.smallest <= 0.01))
    return fail(ErrorCode::InvalidArgument,
                text("islands of ", quality.smallest, " of a picture's area; 0 to 0.01 may be left out"));
  return {};
}

Result<CameraViewMaker> CameraViewMaker::make(const std::string& serial, const CameraModel& model,
                                              const std::string& spec, matting::KeySamples samples) {
  CameraViewMaker node;
  node.serial_ = serial;
  node.model_ = model;
  node.samples_ = std::move(samples);
  Result<std::unique_ptr<matting::Keyer>> keyer = keyer_of(spec, node.samples_, std::nullopt);
  if (!keyer) return blame(serial, keyer.error());
  if (const matting::EmptyStage* stage = (*keyer)->empty_stage();
      stage != nullptr && !stage->alike().fits(model.width, model.height))
    log::warning(text("camera '", serial, "': its plate is ", stage->alike().width(), "x",
                      stage->alike().height(), " and its pictures are ", model.width, "x", model.height,
                      ", so that its keys go without it; shoot another"));
  node.keyers_.insert_or_assign(1, KeyerAtScale(std::move(*keyer)));
  return node;
}

Result<std::unique_ptr<matting::Keyer>> CameraViewMaker::keyer_of(
    const std::string& spec, const matting::KeySamples& samples,
    const std::optional<matting::CleanupOptions>& cleanup) {
  Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_keyer(spec, samples.pictures, cleanup);
  if (!keyer || !samples.empty_stage) return keyer;
  return matting::corrected_by_plate(std::move(*keyer), samples.pictures);
}

Result<matting::LiveKey*> CameraViewMaker::keyer_at(int factor) {
  if (const auto found = keyers_.find(factor); found != keyers_.end()) return &found->second.live;
  const matting::Keyer& whole = *keyers_.at(1).keyer;
  matting::KeySamples samples{.pictures = {}, .empty_stage = samples_.empty_stage};
  for (const Image& sample : samples_.pictures) {
    Result<Image> small = shrink(make_frame({}, sample), factor);
    if (!small) return forward(small);
    samples.pictures.push_back(std::move(*small));
  }
  Result<std::unique_ptr<matting::Keyer>> made =
      keyer_of(whole.spec(), samples, shrunk(whole.cleanup(), factor));
  if (!made) return forward(made);
  return &keyers_.insert_or_assign(factor, KeyerAtScale(std::move(*made))).first->second.live;
}

Result<void> CameraViewMaker::prepare(int factor) {
  const Result<matting::LiveKey*> keyer = keyer_at(factor);
  return keyer ? Result<void>() : blame(serial_, keyer.error());
}

Result<std::shared_ptr<const ForegroundTile>> CameraViewMaker::tile_of(const Frame& frame, const Matte& small,
                                                                       int factor) {
  PixelBox box = subject_box(small, factor, model_.width, model_.height);
  if (box.empty()) return std::shared_ptr<const ForegroundTile>();
  const Result<Frame> part = crop(frame, box);
  if (!part) return forward(part);
  std::shared_ptr<ForegroundTile> tile = tiles_.take();
  tile->x = box.x;
  tile->y = box.y;
  if (Result<void> ok = keyers_.at(1).keyer->suppress_spill(*part, tile->picture); !ok) return forward(ok);
  enlarger_.enlarge(small, factor, box, tile->matte);
  return std::shared_ptr<const ForegroundTile>(std::move(tile));
}

Result<std::shared_ptr<const CameraView>> CameraViewMaker::look(const Frame& frame, const Instant& instant,
                                                                Timestamp produced, bool textured,
                                                                const NodeQuality& quality,
                                                                const matting::CastShade* shade) {
  std::shared_ptr<CameraView> taken = views_.take();
  CameraView& view = *taken;
  view.serial = serial_;
  view.epoch = instant.epoch;
  view.instant = view.exposed = instant.time;
  view.produced = produced;
  view.width = model_.width;
  view.height = model_.height;
  view.known = false;
  view.outline.clear();
  view.tile.reset();
  timings_ = {};
  if (frame.empty() || frame.info.status != FrameStatus::Ok)
    return std::shared_ptr<const CameraView>(std::move(taken));
  if (frame.layout.width != model_.width || frame.layout.height != model_.height)
    return fail(ErrorCode::BadData,
                text("camera '", serial_, "' delivers ", frame.layout.width, "x", frame.layout.height,
                     " and was calibrated at ", model_.width, "x", model_.height, "; set that size"));
  view.exposed = frame.info.exposure_start;

  Stopwatch watch;
  const int factor = quality.shrink;
  const Result<matting::LiveKey*> keyer = keyer_at(factor);
  if (!keyer) return blame(serial_, keyer.error());
  Frame small = frame;
  if (factor > 1) {
    if (Result<void> ok = shrink(frame, factor, sums_, averaged_); !ok) return blame(serial_, ok.error());
    small = borrowed_frame(frame.info, averaged_);
  }
  const Result<Matte> matte = (*keyer)->key(small, shade);
  if (!matte) return blame(serial_, matte.error());
  timings_.key = watch.lap();

  recon::SilhouetteOptions options;
  options.tolerance = quality.tolerance / factor;
  options.smallest = quality.smallest * matte->width * matte->height;
  recon::outline_of(*matte, shrunk(model_, factor), options, outlines_, view.outline);
  const Eigen::Array2d size(model_.width,
                            model_.height);  // the last shrunk pixel may reach beyond the picture
  for (Eigen::Vector2d& p : view.outline.points) p = (p.array() * factor).min(size);
  view.known = true;
  timings_.outline = watch.lap();

  if (textured) {
    Result<std::shared_ptr<const ForegroundTile>> tile = tile_of(frame, *matte, factor);
    if (!tile) return blame(serial_, tile.error());
    view.tile = std::move(*tile);
    timings_.tile = watch.lap();
  }
  return std::shared_ptr<const CameraView>(std::move(taken));
}

}  // namespace floatstage::studio
