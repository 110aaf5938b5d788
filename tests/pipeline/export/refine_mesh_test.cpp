#include "pipeline/export/refine_mesh.h"

#include <gmock/gmock.h>

#include "recon/mesh/mesh_check.h"

namespace floatstage::pipeline {
namespace {

// A closed needle: sides of 1 and of 30.
Mesh needle() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3F, 0.3F, 30}}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}};
}

TEST(RefinedMesh, HasNoSideThatIsTooLongAndTheSameSurface) {
  const Mesh fine = refined(needle(), 0.4);
  float longest = 0;
  for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
    const std::size_t next = t % 3 == 2 ? t - 2 : t + 1;
    longest =
        std::max(longest, (fine.positions[fine.triangles[t]] - fine.positions[fine.triangles[next]]).norm());
  }
  EXPECT_LE(longest, 0.4F);
  EXPECT_NEAR(signed_volume(fine), signed_volume(needle()), 1e-5);
  EXPECT_TRUE(recon::check_mesh(fine).good()) << recon::check_mesh(fine).summary();
}

TEST(RefinedMesh, IsTheMeshItselfWhereThatIsFineEnough) {
  const Mesh same = refined(needle(), 31);
  EXPECT_EQ(same.positions.size(), 4u);
  EXPECT_EQ(same.triangles, needle().triangles);
  EXPECT_TRUE(refined(Mesh{}, 1).empty());
}

}  // namespace
}  // namespace floatstage::pipeline
