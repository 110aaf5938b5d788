#include "tests/capture/frame_source_conformance.h"

#include <fstream>

#include "core/file.h"
#include "core/text.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/capture/pictures.h"
#include "tests/support/fake_source.h"
#include "tests/support/own_network.h"

namespace floatstage::capture {
namespace {

std::unique_ptr<FrameSource> opened(const std::string& uri) {
  Result<std::unique_ptr<FrameSource>> source = open_source(uri);
  EXPECT_THAT(source, IsOk());
  return source ? std::move(*source) : nullptr;
}

std::unique_ptr<FrameSource> replayed(const TempFolder& folder, TakeCodec codec) {
  record_small_take(folder / "take", 2, 8, codec, /*gap=*/3);
  return opened(text("take:", (folder / "take").string(), "#cam0"));
}

// A recording whose disk is pulled: its file ends where nobody had read yet.
PluggedSource replayed_from_a_disk(const TempFolder& folder, TakeCodec codec) {
  record_small_take(folder / "pulled", 2, 8, codec);
  const std::filesystem::path media = folder / "pulled/cam0.mkv";
  const std::string whole = *read_file(media);
  return {opened(text("take:", (folder / "pulled").string(), "#cam0")),
          [media] { std::filesystem::resize_file(media, 100); },
          [media, whole] { std::ofstream(media, std::ios::binary | std::ios::in) << whole; }};
}

// A source together with the camera process that it reads.
class WithItsCamera final : public FrameSource {
 public:
  explicit WithItsCamera(const std::string& more)
      : camera_(std::make_unique<FakeGigeCamera>(1, "FAKE1")),
        source_(opened(camera_->uri("format=gray8&width=64&height=48" + more))) {}
  Result<StreamInfo> start() override { return source_->start(); }
  Result<Frame> next(Nanoseconds timeout) override { return source_->next(timeout); }
  void stop() override { source_->stop(); }
  SourceStats stats() const override { return source_->stats(); }
  void unplug() { camera_->kill(); }
  void plug() { camera_ = std::make_unique<FakeGigeCamera>(1, "FAKE1"); }

 private:
  std::unique_ptr<FakeGigeCamera> camera_;
  std::unique_ptr<FrameSource> source_;
};

std::unique_ptr<FrameSource> gige(const TempFolder&) {
  EXPECT_TRUE(enter_own_network());
  return std::make_unique<WithItsCamera>("&frames=4");
}

PluggedSource gige_with_a_cable(const TempFolder&) {
  EXPECT_TRUE(enter_own_network());
  auto source = std::make_unique<WithItsCamera>("&rate=50");
  WithItsCamera* camera = source.get();
  return {std::move(source), [camera] { camera->unplug(); }, [camera] { camera->plug(); }};
}

// The studio and the script pull their cables themselves.
PluggedSource pulled_by_itself(std::unique_ptr<FrameSource> source) {
  return {std::move(source), [] {}, [] {}};
}

using Step = FakeStep;

INSTANTIATE_TEST_SUITE_P(
    AllSources, FrameSourceConformance,
    testing::Values(
        SourceUnderTest{
            "replay_ffv1", [](const TempFolder& folder) { return replayed(folder, TakeCodec::Ffv1); }, 7, 1,
            false, [](const TempFolder& folder) { return replayed_from_a_disk(folder, TakeCodec::Ffv1); }},
        SourceUnderTest{
            "replay_h264", [](const TempFolder& folder) { return replayed(folder, TakeCodec::H264); }, 7, 1,
            false, [](const TempFolder& folder) { return replayed_from_a_disk(folder, TakeCodec::H264); }},
        SourceUnderTest{"synthetic",
                        [](const TempFolder&) {
                          return opened("synthetic:camera=2&cameras=3&width=24&height=18&samples=1&frames=2");
                        },
                        2, 0, false,
                        [](const TempFolder&) {
                          return pulled_by_itself(
                              opened("synthetic:cameras=3&width=24&height=18&samples=1&gone-after=2"));
                        }},
        SourceUnderTest{"gige", gige, 4, 0, /*live=*/true, gige_with_a_cable},
        SourceUnderTest{"fake",
                        [](const TempFolder&) -> std::unique_ptr<FrameSource> {
                          return std::make_unique<FakeSource>(
                              std::vector<FakeStep>{Step::Deliver, Step::Deliver, Step::Timeout, Step::Gap,
                                                    Step::Starve, Step::Corrupt, Step::Deliver});
                        },
                        5, 2, false,
                        [](const TempFolder&) {
                          return pulled_by_itself(std::make_unique<FakeSource>(
                              std::vector<FakeStep>{Step::Deliver, Step::Timeout, Step::Disconnect}));
                        }}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace floatstage::capture
