#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "render/flow/flow_kernels.h"
#include "render/flow/flow_sweep.h"
#include "tests/render/flow/pictures.h"

namespace floatstage::render::test {
namespace {

struct Size {
  int width, height;
  bool masked;
};

/// Two levels as the solver meets them, with holes in domain and evidence, and a field that leaves the
/// picture.
struct Scene {
  PicturePyramid first, second;
  SplitPlane u, v;

  explicit Scene(const Size& size) {
    const auto [width, height, masked] = size;
    const std::vector<std::uint8_t> a = wavy(width, height, 0, 0), b = wavy(width, height, 2, -1);
    const std::vector<std::uint8_t> state = masked ? disc(width, height) : std::vector<std::uint8_t>();
    const std::uint8_t* mask = masked ? state.data() : nullptr;
    first.build({width, height, a.data(), mask}, 1, {});
    second.build({width, height, b.data(), mask}, 1, {});
    u.reset(width, height);
    v.reset(width, height);
    Random random(7);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        u.at(x, y) = static_cast<float>(random.uniform(-4, 4));
        v.at(x, y) = static_cast<float>(random.uniform(-4, 4));
      }
  }
  const PictureLevel& from() const { return first.level(0); }
  const PictureLevel& into() const { return second.level(0); }
};

/// The field after one warp, u then v, in column order.
std::vector<float> after_one_warp(const FlowKernels& kernels, const Size& size, bool cubic) {
  Scene scene(size);
  FlowSweep sweep;
  sweep.reset(scene.u.width(), scene.u.height(), 3);
  sweep.run(kernels, {}, cubic, scene.from(), scene.into(), scene.u, scene.v);
  std::vector<float> all;
  for (const SplitPlane* plane : {&scene.u, &scene.v})
    for (int y = 0; y < plane->height(); ++y)
      for (int x = 0; x < plane->width(); ++x) all.push_back(plane->at(x, y));
  return all;
}

/// The same in passes over the whole picture, one after the other, as a textbook has it.
std::vector<float> after_one_warp_in_passes(const Size& size, bool cubic, int sweeps) {
  Scene s(size);
  const FlowKernels& k = scalar_flow_kernels();
  const FlowEnergy energy;
  const int width = s.u.width(), height = s.u.height();
  enum {
    kMean,
    kDifference,
    kWeight,
    kDx,
    kDy,
    kDiffusivity,
    kRight,
    kDown,
    kI11,
    kI12,
    kI22,
    kB1,
    kB2,
    kCount
  };
  std::vector<SplitPlane> planes(kCount);
  for (SplitPlane& plane : planes) plane.reset(width, height);
  SplitPlane none;
  none.reset(width, 1);
  auto span = [&](int y) { return s.from().spans[static_cast<std::size_t>(y)]; };
  auto row = [&](int plane, int y) {
    return planes[static_cast<std::size_t>(plane)].row(std::clamp(y, 0, height - 1));
  };
  auto three = [&](int plane, int y) {
    return ThreeRows{row(plane, y - 1), row(plane, y), row(plane, y + 1)};
  };
  auto of = [&](SplitPlane& plane, int y) { return plane.row(std::clamp(y, 0, height - 1)); };
  for (int y = 0; y < height; ++y)
    for (SplitRow end : {s.u.row(y), s.v.row(y)}) replicate_ends(end, width);
  for (int y = 0; y < height; ++y) {
    if (span(y).empty()) continue;
    k.warp(span(y), y, cubic, s.u.row(y), s.v.row(y), s.from().first.row(y), s.from().data.row(y),
           s.into().sampled(), row(kMean, y), row(kDifference, y), row(kWeight, y));
    for (int plane : {kMean, kDifference}) replicate_ends(row(plane, y), width);
    k.diffusivity(span(y), energy, s.u.row(y), of(s.u, y + 1), s.v.row(y), of(s.v, y + 1),
                  s.from().stiffness.row(y), row(kDiffusivity, y));
  }
  for (int y = 0; y < height; ++y) {
    k.gradient(span(y), three(kMean, y), row(kDx, y), row(kDy, y));
    replicate_ends(row(kDx, y), width);
    k.neighbors(span(y), row(kDiffusivity, y),
                y + 1 < height ? ConstSplitRow(row(kDiffusivity, y + 1)) : none.row(0), row(kRight, y),
                row(kDown, y));
  }
  auto equations = [&](int y) {
    return EquationRow{row(kI11, y), row(kI12, y), row(kI22, y), row(kB1, y), row(kB2, y)};
  };
  auto above = [&](int y) { return y > 0 ? ConstSplitRow(row(kDown, y - 1)) : none.row(0); };
  for (int y = 0; y < height; ++y)
    k.equations(span(y), energy, three(kDx, y), three(kDy, y), three(kDifference, y), row(kWeight, y),
                s.u.row(y), s.v.row(y), row(kRight, y), row(kDown, y), above(y), equations(y));
  for (int h = 0; h < 2 * sweeps; ++h)
    for (int y = 0; y < height; ++y)
      k.relax(span(y), (y + h) & 1, energy.omega, equations(y), row(kRight, y), row(kDown, y), above(y),
              {of(s.u, y - 1), s.u.row(y), of(s.u, y + 1)}, {of(s.v, y - 1), s.v.row(y), of(s.v, y + 1)},
              s.u.row(y), s.v.row(y));
  std::vector<float> all;
  for (const SplitPlane* plane : {&s.u, &s.v})
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) all.push_back(plane->at(x, y));
  return all;
}

TEST(FlowKernels, TheScalarOnesAreThereAndTheNativeOnesAmongAll) {
  const std::vector<FlowKernels> all = all_flow_kernels();
  EXPECT_EQ(all.front().name, "scalar");
  EXPECT_THAT(all, testing::Contains(testing::Field(&FlowKernels::name, native_flow_kernels().name)));
  EXPECT_EQ(native_flow_kernels().warp, [&] {
    for (const FlowKernels& k : all)
      if (k.name == native_flow_kernels().name) return k.warp;
    return all.front().warp;
  }());
}

TEST(FlowKernels, EveryInstructionSetGivesTheSameBits) {
  for (const auto& [width, height] :
       {std::pair(97, 61), std::pair(64, 20), std::pair(1, 1), std::pair(3, 40)})
    for (const bool masked : {false, true})
      for (const bool cubic : {false, true}) {
        const Size scene{width, height, masked};
        const std::vector<float> expected = after_one_warp(scalar_flow_kernels(), scene, cubic);
        for (float value : expected) ASSERT_TRUE(std::isfinite(value));
        for (const FlowKernels& kernels : all_flow_kernels())
          EXPECT_EQ(after_one_warp(kernels, scene, cubic), expected)
              << kernels.name << ", " << width << "x" << height << (masked ? ", masked" : "");
      }
}

TEST(FlowSweep, TheWavefrontGivesTheBitsOfOnePassAfterTheOther) {
  for (const auto& [width, height] : {std::pair(97, 61), std::pair(40, 3), std::pair(5, 1)})
    for (const bool masked : {false, true}) {
      const Size scene{width, height, masked};
      EXPECT_EQ(after_one_warp(scalar_flow_kernels(), scene, false),
                after_one_warp_in_passes(scene, false, 3))
          << width << "x" << height << (masked ? ", masked" : "");
    }
}

TEST(FlowSweep, ComputesNothingBeyondTheBandOfTheProxy) {
  Scene scene({97, 61, true});
  const Scene before({97, 61, true});
  FlowSweep sweep;
  sweep.reset(97, 61, 3);
  sweep.run(native_flow_kernels(), {}, false, scene.from(), scene.into(), scene.u, scene.v);
  int outside = 0;
  for (int x = 0; x < 97; ++x)
    outside += scene.from().zone[static_cast<std::size_t>(x)] == PictureLevel::kOutside;
  ASSERT_EQ(outside, 97) << "the disc does not touch the first row";
  for (int x = 0; x < 97; ++x) EXPECT_EQ(scene.u.at(x, 0), before.u.at(x, 0));
}

}  // namespace
}  // namespace floatstage::render::test
