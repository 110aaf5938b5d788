#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/zipmap/layer_cache.h"
#include "render/zipmap/zipmap_needs.h"
#include "tests/render/zipmap/pictures.h"

namespace floatstage::render {
namespace {

using namespace test;
using testing::ElementsAre;

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

std::vector<std::size_t> patches_of(const std::vector<PatchNeed>& needs) {
  std::vector<std::size_t> out;
  for (const PatchNeed& need : needs) out.push_back(need.patch);
  return out;
}

// Four patches of one picture each, in the corners of the root.
Zipmap corners() {
  return *Zipmap::make(
      Image(64, 64, 3), {Image(64, 64, 3), Image(64, 64, 3), Image(64, 64, 3), Image(64, 64, 3)},
      {patch(0, 0, 0, 0.25), patch(1, 0.75, 0, 0.25), patch(2, 0, 0.75, 0.25), patch(3, 0.75, 0.75, 0.25)});
}

TEST(AView, NeedsThePatchesThatItShowsAtTheLevelsAtWhichItShowsThem) {
  const Zipmap zipmap = corners();
  // The whole root on 64 px: a patch of 64 texels on 16 px, two levels coarser.
  const std::vector<PatchNeed> all = needs_of(zipmap, {window(0, 0, 1, 64), 64, 64});
  ASSERT_THAT(patches_of(all), ElementsAre(0, 1, 2, 3));
  for (const PatchNeed& need : all) EXPECT_EQ(need.level, 2u);
  const std::vector<PatchNeed> one = needs_of(zipmap, {window(0.7, 0, 0.25, 64), 64, 64});
  ASSERT_THAT(patches_of(one), ElementsAre(1));
  EXPECT_EQ(one[0].level, 0u);
  EXPECT_GT(one[0].pixels, all[1].pixels);
  EXPECT_THAT(needs_of(zipmap, {window(0.3, 0.3, 0.25, 64), 64, 64}), testing::IsEmpty());
}

TEST(AView, BeyondTheRootsEdgeNeedsWhatIsFoldedThere) {
  const Zipmap zipmap = corners();
  const Eigen::Matrix3d beyond = window(1.8, 0.8, 0.1, 64);
  EXPECT_THAT(patches_of(needs_of(zipmap, {beyond, 64, 64, Zipmap::Wrap::Repeat})), ElementsAre(3));
  EXPECT_THAT(patches_of(needs_of(zipmap, {beyond, 64, 64, Zipmap::Wrap::Mirror})), ElementsAre(2));
  EXPECT_THAT(patches_of(needs_of(zipmap, {beyond, 64, 64, Zipmap::Wrap::Clamp})), ElementsAre(3));
}

TEST(Layers, GoToThePicturesThatWereNeededLast) {
  const Zipmap zipmap = corners();
  LayerCache cache(zipmap, 2);
  std::size_t waiting = 0;
  EXPECT_EQ(cache.passes({{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}).size(), 2u);
  EXPECT_EQ(cache.load({{0, 6, 1}, {1, 6, 1}}, kAll, waiting).size(), 2u);
  EXPECT_TRUE(cache.load({{1, 6, 1}}, kAll, waiting).empty()) << "it is there";
  EXPECT_EQ(cache.load({{2, 6, 1}}, kAll, waiting).size(), 1u);
  EXPECT_EQ(cache.layer_of(0), -1) << "the one that was not needed for longest";
  EXPECT_GE(cache.layer_of(1), 0);
  EXPECT_EQ(cache.finest(0), 7u);
  EXPECT_EQ(waiting, 0u);
}

TEST(Layers, AreLoadedFromCoarseToFineAndWhereMostOfTheViewWaitsFirst) {
  const Zipmap zipmap = corners();
  LayerCache cache(zipmap, 4);
  const std::vector<PatchNeed> pass = {{0, 0, 10}, {1, 0, 1000}, {2, 3, 1000}};
  std::size_t before = std::numeric_limits<std::size_t>::max();
  std::vector<LayerLoad> loads;
  for (int turn = 0; turn < 100; ++turn) {
    std::size_t waiting = 0;
    const std::vector<LayerLoad> now = cache.load(pass, 600, waiting);
    loads.insert(loads.end(), now.begin(), now.end());
    EXPECT_LT(waiting, before);
    before = waiting;
    if (waiting == 0) break;
  }
  EXPECT_EQ(before, 0u);
  ASSERT_EQ(loads.size(), 7u + 7u + 4u) << "no level twice, none that is finer than needed";
  EXPECT_EQ(loads.front().picture, 1u);
  EXPECT_EQ(loads.back().picture, 0u) << "ten pixels can wait";
  for (std::size_t picture = 0; picture < 3; ++picture) {
    std::size_t level = 7;
    for (const LayerLoad& load : loads)
      if (load.picture == picture) {
        EXPECT_EQ(load.level, --level);
      }
  }
}

}  // namespace
}  // namespace floatstage::render
