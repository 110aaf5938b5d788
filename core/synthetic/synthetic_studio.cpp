#include "core/synthetic/synthetic_studio.h"

#include <cmath>
#include <cstring>
#include <future>
#include <list>
#include <mutex>

#include "core/parallel.h"
#include "core/random.h"
#include "core/synthetic/calibration_error.h"
#include "core/synthetic/performer.h"
#include "core/synthetic/photograph.h"
#include "core/synthetic/room.h"
#include "core/synthetic/sensor.h"
#include "core/synthetic/stage_scene.h"
#include "core/text.h"

namespace floatstage {
namespace {

using synthetic::Exposure;
using synthetic::StageScene;
using synthetic::TracingCamera;

// A scene is about six megabytes; the cameras of a frame are mostly shot together.
constexpr std::size_t kCachedScenes = 6;

Result<void> check_options(const SyntheticStudioOptions& o) {
  const int across = static_cast<int>(std::lround(std::sqrt(o.samples)));
  if (o.samples < 1 || o.samples > 1024 || across * across != o.samples)
    return fail(ErrorCode::InvalidArgument,
                text("samples is ", o.samples, "; use a square number from 1 to 1024"));
  if (!(o.frame_rate > 0 && std::isfinite(o.frame_rate)))
    return fail(ErrorCode::InvalidArgument, text("frame_rate is ", o.frame_rate, "; use a positive number"));
  const Defects& d = o.defects;
  const std::pair<const char*, double> amounts[] = {{"noise", d.noise},
                                                    {"color_gain", d.color_gain},
                                                    {"calibration_error", d.calibration_error},
                                                    {"green_spill", d.green_spill},
                                                    {"dropped_frames", d.dropped_frames},
                                                    {"time_jitter", d.time_jitter}};
  for (const auto& [name, amount] : amounts)
    if (!(amount >= 0 && std::isfinite(amount)))
      return fail(ErrorCode::InvalidArgument, text("defect ", name, " is ", amount, "; use 0 or more"));
  for (const auto& [name, share] :
       {std::pair("green_spill", d.green_spill), std::pair("dropped_frames", d.dropped_frames)})
    if (share > 1)
      return fail(ErrorCode::InvalidArgument, text("defect ", name, " is ", share, "; use 0 to 1"));
  if (!(std::abs(d.lens_k1) <= 1))
    return fail(ErrorCode::InvalidArgument, text("defect lens_k1 is ", d.lens_k1, "; use -1 to 1"));
  return {};
}

bool has_green_cloth(SyntheticStage stage) {
  using enum SyntheticStage;
  return stage == Green || stage == GreenBlack || stage == Markers || stage == Cables ||
         stage == GreenClothes;
}

// A shot's truth.
void add_truth(const Exposure& exposure, const FrameInfo& info, SyntheticShot& shot) {
  Image alpha(exposure.width, exposure.height, 1);
  for (const std::vector<std::uint8_t>& of : exposure.alpha_of) {
    alpha.pixels = of;
    shot.matte_of.push_back(make_matte(info, alpha));
  }
  alpha.pixels = exposure.alpha;
  shot.matte = make_matte(info, alpha);
  shot.depth = exposure.depth;
}

}  // namespace

struct SyntheticStudio::Impl {
  Impl(const Rig& rig, const SyntheticStudioOptions& o)
      : options(o),
        true_rig(rig),
        published(synthetic::with_calibration_error(rig, o.defects.calibration_error, o.seed)),
        sensor{o.seed, o.defects, o.frame_rate},
        performer(o.seed, o.cast),
        room(rig, o.stage, o.seed),
        device(rtcNewDevice("threads=1,set_affinity=0")) {
    for (const RigCamera& c : rig.cameras) {
      if (options.stop && options.stop()) return;  // create() says so
      cameras.emplace_back(c.model, c.cam_from_world);
    }
    plates.resize(cameras.size());
    parallel_for(cameras.size(), 0, [&](std::size_t i) {
      plates[i] = synthetic::photograph_room(cameras[i], room, options.stop);
    });
  }

  synthetic::PhotographOptions photograph_options() const {
    return {.samples_across = static_cast<int>(std::lround(std::sqrt(options.samples))),
            .spill = has_green_cloth(options.stage) ? static_cast<float>(options.defects.green_spill) : 0,
            .dress = options.stage == SyntheticStage::GreenClothes ? synthetic::Dress::OfTheCloth
                                                                   : synthetic::Dress::Usual,
            .seed = static_cast<std::uint32_t>(mix(options.seed)),
            .stop = options.stop};
  }

  Timestamp instant(int frame) const { return {std::llround(frame / options.frame_rate * 1e9)}; }

  // The scene at an instant: built by the first thread that asks, awaited by the others, kept for a while.
  std::shared_ptr<const StageScene> scene_at(Timestamp time) const {
    std::promise<std::shared_ptr<const StageScene>> mine;
    {
      std::unique_lock lock(mutex);
      for (auto it = scenes.begin(); it != scenes.end(); ++it) {
        if (it->first != time) continue;
        scenes.splice(scenes.begin(), scenes, it);
        const auto theirs = scenes.front().second;
        lock.unlock();
        return theirs.get();
      }
      scenes.emplace_front(time, mine.get_future().share());
      if (scenes.size() > kCachedScenes) scenes.pop_back();
    }
    try {
      auto scene = std::make_shared<const StageScene>(device.get(), performer, seconds(time - Timestamp{}));
      mine.set_value(scene);
      return scene;
    } catch (...) {
      mine.set_exception(std::current_exception());
      throw;
    }
  }

  SyntheticStudioOptions options;
  Rig true_rig, published;
  synthetic::SensorDefects sensor;
  synthetic::Performer performer;
  synthetic::Room room;
  synthetic::Device device;
  std::vector<TracingCamera> cameras;
  std::vector<Image> plates;  ///< without gain
  mutable std::mutex mutex;
  mutable std::list<std::pair<Timestamp, std::shared_future<std::shared_ptr<const StageScene>>>>
      scenes;  ///< newest use first
};

Result<SyntheticStudio> SyntheticStudio::create(const Rig& true_rig, const SyntheticStudioOptions& options) {
  if (Result<void> ok = floatstage::check(true_rig); !ok) return forward(ok);
  if (Result<void> ok = check_options(options); !ok) return forward(ok);
  Rig rig = true_rig;
  const double k1 = options.defects.lens_k1;
  if (k1 != 0)
    for (RigCamera& c : rig.cameras) c.model.lens = BrownConrady{.k1 = k1, .k2 = -k1 / 4};
  auto impl = std::make_unique<Impl>(rig, options);
  if (!impl->device)
    return fail(ErrorCode::Unsupported,
                "Embree found no usable instruction set on this machine (it needs SSE2)");
  if (options.stop && options.stop())
    return fail(ErrorCode::Cancelled, "interrupted while the stage was photographed");
  return SyntheticStudio(std::move(impl));
}

SyntheticStudio::SyntheticStudio(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SyntheticStudio::SyntheticStudio(SyntheticStudio&&) noexcept = default;
SyntheticStudio& SyntheticStudio::operator=(SyntheticStudio&&) noexcept = default;
SyntheticStudio::~SyntheticStudio() = default;

const Rig& SyntheticStudio::true_rig() const { return impl_->true_rig; }
const Rig& SyntheticStudio::published_rig() const { return impl_->published; }

SyntheticShot SyntheticStudio::shoot(int camera, int frame) const {
  FLOATSTAGE_CHECK(camera >= 0 && camera < static_cast<int>(impl_->cameras.size()),
                   text("no camera ", camera));
  FLOATSTAGE_CHECK(frame >= 0, text("frame ", frame, " is before the first"));
  const std::size_t i = static_cast<std::size_t>(camera);
  FrameInfo info{.camera = camera,
                 .sequence = static_cast<std::uint64_t>(frame),
                 .exposure_start = impl_->sensor.exposure_start(camera, frame),
                 .exposure = {},
                 .device_time = {}};
  SyntheticShot shot;
  if (impl_->sensor.dropped(camera, frame)) {
    info.exposure_start = impl_->instant(frame);
    info.status = FrameStatus::Lost;
    shot.frame.info = info;
    shot.matte.source = info;
    return shot;
  }
  info.device_time = Nanoseconds{info.exposure_start.ns};
  const Exposure exposure = synthetic::photograph(impl_->cameras[i], *impl_->scene_at(info.exposure_start),
                                                  impl_->plates[i], impl_->photograph_options());
  shot.frame = make_frame(
      info, synthetic::develop(exposure, impl_->sensor.gain(camera), impl_->options.defects.noise,
                               synthetic::key(impl_->options.seed, synthetic::kNoiseKey, camera, frame)));
  add_truth(exposure, info, shot);
  return shot;
}

SyntheticShot SyntheticStudio::shoot_view(const View& view, int frame) const {
  const TracingCamera camera(view.model, view.view_from_world);
  const FrameInfo info{.sequence = static_cast<std::uint64_t>(frame),
                       .exposure_start = impl_->instant(frame),
                       .exposure = {},
                       .device_time = {}};
  const Exposure exposure =
      synthetic::photograph(camera, *impl_->scene_at(info.exposure_start),
                            synthetic::photograph_room(camera, impl_->room), impl_->photograph_options());
  SyntheticShot shot;
  shot.frame = make_frame(info, synthetic::develop(exposure, Eigen::Vector3f::Ones(), 0, 0));
  add_truth(exposure, info, shot);
  return shot;
}

Image SyntheticStudio::plate(int camera) const {
  FLOATSTAGE_CHECK(camera >= 0 && camera < static_cast<int>(impl_->cameras.size()),
                   text("no camera ", camera));
  return synthetic::with_gain(impl_->plates[static_cast<std::size_t>(camera)], impl_->sensor.gain(camera));
}

Mesh SyntheticStudio::performer(int frame) const {
  const synthetic::Performer& p = impl_->performer;
  Mesh mesh;
  mesh.positions = p.positions(seconds(impl_->instant(frame) - Timestamp{}));
  mesh.positions.resize(p.shell_vertices());
  mesh.triangles.assign(p.triangles().begin(),
                        p.triangles().begin() + static_cast<std::ptrdiff_t>(3 * p.shell_triangles()));
  return mesh;
}

}  // namespace floatstage
