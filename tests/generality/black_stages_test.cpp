#include <cstdio>
#include <numeric>

#include <gtest/gtest.h>

#include "matting/keyers/keyer.h"
#include "recon/visual_hull.h"
#include "tests/generality/sets.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::generality {
namespace {

// Nobody gives a number: the silhouettes of all cameras have to fit one body all the same.
TEST(LuminanceWithoutANumber, GivesSilhouettesThatFitOneBody) {
  int tried = 0;
  for (const SetName& row : all_sets()) {
    if (!row.name.starts_with("middlebury")) continue;
    FLOATSTAGE_NEEDS_DATA(row.data);
    const StageSet set = row.load(true);
    std::vector<Matte> mattes;
    for (const Image& picture : set.pictures[0]) {
      const auto keyer = matting::make_keyer("luminance", {picture});
      ASSERT_THAT(keyer, IsOk());
      const auto matte = (*keyer)->key(make_frame({}, picture));
      ASSERT_THAT(matte, IsOk());
      mattes.push_back(*matte);
    }
    const Result<recon::HullReport> hull = recon::visual_hull(set.rig, mattes, {});
    ASSERT_THAT(hull, IsOk());
    const std::vector<double>& ious = hull->silhouette_iou;
    const double mean = std::accumulate(ious.begin(), ious.end(), 0.0) / static_cast<double>(ious.size());
    std::printf("%s: mean silhouette IoU %.4f\n", row.name.c_str(), mean);
    EXPECT_GE(mean, 0.97) << row.name;
    ++tried;
  }
  EXPECT_EQ(tried, 3);
}

}  // namespace
}  // namespace floatstage::generality
