// A program of its own: it replaces operator new to count.

#include "core/reused.h"
#include "render/back_end.h"
#include "studio/live/live_view.h"
#include "studio/live/reconstruction.h"
#include "studio/node/camera_rack.h"
#include "tests/studio/synthetic_shots.h"
#include "tests/support/counted_new.h"

namespace floatstage::studio {
namespace {

struct Counts {
  long nodes = 0, hull = 0, upload = 0, render = 0;
  long sum() const { return nodes + hull + upload + render; }
};

// Serials as cameras have them, which do not fit into a string's own bytes.
Rig with_long_serials(Rig rig) {
  for (RigCamera& camera : rig.cameras) camera.serial = "Company-Model-1234-" + camera.serial;
  return rig;
}

/// How a chain is run.
struct How {
  std::size_t quality = 0;  // of live_qualities()
  int threads = 1;
  PixelFormat format = PixelFormat::Rgb8;
};

// The photograph as a camera with a colour filter array delivers it.
Frame mosaic(const Frame& frame) {
  const Image rgb = *to_rgb(frame);
  Image bayer(rgb.width, rgb.height, 1);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x) *bayer.at(x, y) = rgb.at(x, y)[(x & 1) + (y & 1)];
  Frame out = make_frame(frame.info, bayer);
  out.layout = packed_layout(PixelFormat::BayerRggb8, rgb.width, rgb.height);
  return out;
}

// The chain of one machine without its threads: keys, outlines, tiles, hull, textures, picture. As in the
// live chain, the scene before is drawn while one is made.
class Chain {
 public:
  static constexpr int kCameras = 6;

  explicit Chain(const How& how) : how_(how) {
    for (int f = 0; f < 3; ++f) {
      TimedSet& set = sets_.emplace_back();
      set.instant.epoch = static_cast<std::uint64_t>(f);
      for (int c = 0; c < kCameras; ++c) {
        const Frame frame = shots_.studio.shoot(c, 12 * f).frame;
        set.images.frames.push_back(how.format == PixelFormat::BayerRggb8 ? mosaic(frame) : frame);
      }
      set.produced.resize(kCameras);
    }
  }

  Counts instant(int i) {
    Counts counts;
    long before = test::allocations;
    const auto lap = [&](long& count) {
      count = test::allocations - before;
      before = test::allocations;
    };
    const std::shared_ptr<LiveScene> scene = scenes_.take();
    const LiveQuality& quality = live_qualities()[how_.quality];
    rack_.look(sets_[static_cast<std::size_t>(i) % sets_.size()], textured_, quality.node, how_.threads,
               scene->times, scene->views);
    lap(counts.nodes);
    EXPECT_TRUE(reconstruction_.make(scene->views, how_.threads, scene->scene));  // matchers allocate
    lap(counts.hull);
    EXPECT_TRUE(view_.show(scene));
    lap(counts.upload);
    render::RendererOptions options;
    options.alignment = render::Alignment::Auto;  // as `live` has it
    options.back_end = render::BackEnd::Cpu;
    options.threads = how_.threads;
    const auto picture = view_.render(from_, quality, options);
    EXPECT_TRUE(picture && *picture);
    lap(counts.render);
    return counts;
  }

 private:
  const How how_;
  SyntheticShots shots_{kCameras};
  const Rig rig_ = with_long_serials(shots_.rig);
  std::vector<TimedSet> sets_;
  CameraRack rack_ =
      std::move(*CameraRack::make(rig_, "chroma:#2f7a45", std::vector<matting::KeySamples>(kCameras)));
  Reconstruction reconstruction_{rig_, std::string(64, '0')};
  Reused<LiveScene> scenes_;
  LiveView view_{rig_};
  View from_ = {shots_.rig.cameras[0].model, shots_.rig.cameras[0].cam_from_world, 0.1, 100};
  std::vector<bool> textured_ = {true, true, false, false, false, true};
};

constexpr int kCounted = 12;  // instants

class LiveChain : public testing::TestWithParam<How> {};

// Also what one thread hands to another, views, tiles, the surface, comes back and is used again.
TEST_P(LiveChain, AllocatesNothingOnceItIsWarm) {
  Chain chain(GetParam());
  constexpr int kWarmUp = 6;
  for (int i = 0; i < kWarmUp + kCounted; ++i) {
    const Counts counts = chain.instant(i);
    if (i == 0) {
      EXPECT_GT(counts.sum(), 1000) << "the counter counts";
    }
    if (i < kWarmUp) continue;
    EXPECT_EQ(counts.nodes, 0) << "instant " << i;
    EXPECT_EQ(counts.hull, 0) << "instant " << i;
    EXPECT_EQ(counts.upload, 0) << "instant " << i;
    EXPECT_EQ(counts.render, 0) << "instant " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryWay, LiveChain,
                         testing::Values(How{}, How{.quality = 2}, How{.quality = 4}, How{.quality = 5},
                                         How{.format = PixelFormat::BayerRggb8}),
                         [](const testing::TestParamInfo<How>& test) {
                           return live_qualities()[test.param.quality].name +
                                  (test.param.format == PixelFormat::Rgb8 ? "" : "OfMosaics");
                         });

// Which thread takes which part is chance, and what a thread works in grows with the largest part it took.
TEST(LiveChainOnTwoThreads, ComesToAllocateNothing) {
  Chain chain({.threads = 2});
  int in_a_row = 0, instants = 0;
  for (; in_a_row < kCounted && instants < 300; ++instants)
    in_a_row = chain.instant(instants).sum() == 0 ? in_a_row + 1 : 0;
  EXPECT_EQ(in_a_row, kCounted) << "in " << instants << " instants";
}

}  // namespace
}  // namespace floatstage::studio
