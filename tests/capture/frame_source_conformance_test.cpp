#include "tests/capture/frame_source_conformance.h"

#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/fake_source.h"

namespace floatstage {
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

using Step = FakeStep;

INSTANTIATE_TEST_SUITE_P(
    AllSources, FrameSourceConformance,
    testing::Values(
        SourceUnderTest{"replay_ffv1",
                        [](const TempFolder& folder) { return replayed(folder, TakeCodec::Ffv1); }, 7, 1},
        SourceUnderTest{"replay_h264",
                        [](const TempFolder& folder) { return replayed(folder, TakeCodec::H264); }, 7, 1},
        SourceUnderTest{"synthetic",
                        [](const TempFolder&) {
                          return opened("synthetic:camera=2&cameras=3&width=24&height=18&samples=1&frames=2");
                        },
                        2, 0},
        SourceUnderTest{"fake",
                        [](const TempFolder&) -> std::unique_ptr<FrameSource> {
                          return std::make_unique<FakeSource>(
                              std::vector<FakeStep>{Step::Warmup, Step::Deliver, Step::Timeout, Step::Gap,
                                                    Step::Starve, Step::Corrupt, Step::Deliver});
                        },
                        5, 2}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace floatstage
