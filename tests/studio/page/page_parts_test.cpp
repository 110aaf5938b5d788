#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "studio/page/node_metrics.h"
#include "studio/page/preview.h"
#include "tests/support/matchers.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;

TEST(Preview, IsTheMeanOfThePixelsThatEachStandsFor) {
  Image image(8, 4, 1);
  std::iota(image.pixels.begin(), image.pixels.end(), std::uint8_t{0});
  const Result<Image> small = preview_picture(make_frame({}, image), 4);
  ASSERT_THAT(small, IsOk());
  EXPECT_EQ(small->width, 4);
  EXPECT_EQ(small->height, 2);
  ASSERT_EQ(small->channels, 3);
  EXPECT_EQ(small->pixels[0], (0 + 1 + 8 + 9) / 4);
  EXPECT_EQ(small->pixels[21], (22 + 23 + 30 + 31) / 4);
  EXPECT_THAT(preview_picture(Frame{}, 4), FailsWith(ErrorCode::NotFound, ""));
}

TEST(NodeMetrics, AreInPrometheusText) {
  NodeStatus status;
  status.cameras.resize(1);
  status.cameras[0].serial = "A\"1";
  status.cameras[0].delivered = 41;
  status.cameras[0].trouble = "gone";
  status.spread_max_ms = 2;
  const std::string metrics = prometheus_text(status, {10, 3, 1, 4});
  EXPECT_THAT(metrics,
              HasSubstr("floatstage_camera_frames_total{camera=\"A\\\"1\",result=\"delivered\"} 41\n"));
  EXPECT_THAT(metrics, HasSubstr("floatstage_camera_up{camera=\"A\\\"1\"} 0\n"));
  EXPECT_THAT(metrics, HasSubstr("floatstage_sync_spread_seconds{quantile=\"1\"} 0.002\n"));
  EXPECT_THAT(metrics,
              HasSubstr("# TYPE floatstage_page_refused_total counter\nfloatstage_page_refused_total 3\n"));
  EXPECT_THAT(metrics, testing::Not(HasSubstr("{camera=\"A\\\"1\"} nan")));
}

}  // namespace
}  // namespace floatstage::studio
