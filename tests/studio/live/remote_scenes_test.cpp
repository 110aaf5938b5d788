#include "studio/live/remote_scenes.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "recon/outline.h"
#include "studio/live/recon_service.h"
#include "studio/messages/clock.h"
#include "studio/network/publisher.h"
#include "tests/studio/synthetic_shots.h"
#include "tests/support/eventually.h"

namespace floatstage::studio {
namespace {

constexpr const char* kAnyPort = "tcp://127.0.0.1:0";
constexpr int kCameras = 8;
constexpr std::chrono::seconds kPatience{120};  // the watch rests between two instants, and gives way

// What a node tells of one instant; the camera `faulty` lacks the lower half of its picture.
std::vector<CameraView> instant(const SyntheticShots& shots, int faulty) {
  std::vector<CameraView> views;
  for (int c = 0; c < kCameras; ++c) {
    const RigCamera& camera = shots.rig.cameras[static_cast<std::size_t>(c)];
    Image matte = to_image(shots.studio.shoot(c, 0).matte);
    if (c == faulty)
      std::fill_n(matte.at(0, matte.height / 2), matte.width * (matte.height / 2), std::uint8_t{0});
    CameraView view;
    view.serial = camera.serial;
    view.width = camera.model.width;
    view.height = camera.model.height;
    view.known = true;
    view.outline = recon::outline_of(make_matte({}, matte), camera.model);
    views.push_back(std::move(view));
  }
  return views;
}

// The machine with a screen has neither outlines nor keys: what is wrong with them comes with the scenes.
TEST(RemoteScenes, TellWhatIsWrongWithTheSilhouettesOfOtherMachines) {
  const SyntheticShots shots(kCameras);
  const std::unique_ptr<wire::Publisher> node = *wire::Publisher::bind({.address = kAnyPort});
  ReconOptions recon;
  recon.nodes = {node->address()};
  recon.publisher.address = kAnyPort;
  const std::unique_ptr<ReconService> service = *ReconService::open(shots.rig, recon);
  RemoteOptions options;
  options.recon = service->address();
  options.nodes = {node->address()};
  const std::unique_ptr<RemoteScenes> scenes = *RemoteScenes::open(shots.rig, options);
  const std::vector<CameraView> seen = instant(shots, 2);
  std::uint64_t epoch = 0;
  EXPECT_TRUE(eventually(
      [&] {
        const Timestamp time = now() + to_studio_time();
        ++epoch;
        for (CameraView view : seen) {
          view.epoch = epoch;
          view.instant = view.exposed = view.produced = time;
          node->publish(std::make_shared<const CameraView>(std::move(view)));
        }
        scenes->newest(now() + milliseconds(50));
        return scenes->remark().find("camera 'cam02' lacks") != std::string::npos;
      },
      kPatience))
      << scenes->remark();
}

}  // namespace
}  // namespace floatstage::studio
