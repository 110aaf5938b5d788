#include <cmath>
#include <cstdint>
#include <string_view>

#include "calib/colmap_model.h"
#include "core/check.h"

// Whatever parses has points that two images show, and finite means.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  (void)parse_colmap_keypoints({reinterpret_cast<const char*>(data), size}, "fuzz");
  const Result<ColmapPoints> points = parse_colmap_points({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!points) return 0;
  FLOATSTAGE_CHECK(!points->points.empty() && points->mean_track >= 1 && std::isfinite(points->mean_error), "means of nothing");
  return 0;
}
