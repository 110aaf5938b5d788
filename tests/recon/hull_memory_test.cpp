// A program of its own: it replaces operator new to count.

#include <atomic>
#include <cstdlib>
#include <new>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace {

std::atomic<std::int64_t> allocations = 0;

void* counted(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace floatstage::recon {
namespace {

struct Sequence {
  Rig rig;
  std::vector<std::vector<Matte>> frames;
};

Sequence dancing_shapes() {
  Sequence out;
  out.rig = shapes::ring_rig({.cameras = 7, .distance = 3, .width = 200, .height = 150, .focal = 170}, 0.6);
  for (RigCamera& camera : out.rig.cameras) camera.model.lens = BrownConrady{-0.05, 0.01, 0, 0, 0};
  for (const double x : {0.03, 0.11, 0.2}) {
    out.frames.push_back(
        shapes::render_mattes(out.rig, shapes::both(shapes::torus({x, 0.02, 0.01}, 0.4, 0.12),
                                                    shapes::box({-x, 0.1, 0.2}, {0.2, 0.2, 0.7}))));
  }
  return out;
}

std::int64_t allocations_of_later_frames(const HullOptions& options) {
  const Sequence sequence = dancing_shapes();
  HullWorkspace workspace;
  HullReport report;
  for (const auto& mattes : sequence.frames)
    EXPECT_THAT(visual_hull(sequence.rig, mattes, options, workspace, report), IsOk());
  EXPECT_GT(report.mesh.triangle_count(), 500u);
  const std::int64_t before = allocations;
  for (int lap = 0; lap < 2; ++lap) {
    for (const auto& mattes : sequence.frames) {
      const Result<void> ok = visual_hull(sequence.rig, mattes, options, workspace, report);
      if (!ok || report.escalations > 0) return -1;  // a frame computed twice may need more memory
    }
  }
  return allocations - before;
}

HullOptions live() {
  HullOptions options;
  options.threads = 1;
  options.quality = false;
  return options;
}

TEST(HullMemory, IsCountedAtAll) {
  const std::int64_t before = allocations;
  EXPECT_EQ(std::vector<int>(100).size(), 100u);
  EXPECT_GT(allocations, before);
}

TEST(HullMemory, IsNotAskedForInLaterFrames) { EXPECT_EQ(allocations_of_later_frames(live()), 0); }

TEST(HullMemory, IsNotAskedForInLaterFramesOfAVoteEither) {
  HullOptions options = live();
  options.voting = HullVoting::MofN;
  options.votes = 6;
  EXPECT_EQ(allocations_of_later_frames(options), 0);
}

TEST(HullMemory, OfTheReportServesTheNextFrameAndDoesNotChangeIt) {
  const Sequence sequence = dancing_shapes();
  HullWorkspace workspace;
  HullReport kept;
  for (const auto& mattes : sequence.frames) {
    ASSERT_THAT(visual_hull(sequence.rig, mattes, live(), workspace, kept), IsOk());
    const Result<HullReport> fresh = visual_hull(sequence.rig, mattes, live());
    ASSERT_THAT(fresh, IsOk());
    EXPECT_EQ(kept.mesh.positions, fresh->mesh.positions);
    EXPECT_EQ(kept.mesh.triangles, fresh->mesh.triangles);
    EXPECT_EQ(kept.sources, fresh->sources);
    EXPECT_EQ(kept.volume, fresh->volume);
    EXPECT_EQ(kept.remarks, fresh->remarks);
  }
  const std::vector<Matte> none(sequence.rig.cameras.size());
  EXPECT_FALSE(visual_hull(sequence.rig, none, live(), workspace, kept));
  EXPECT_TRUE(kept.mesh.empty());
}

}  // namespace
}  // namespace floatstage::recon
