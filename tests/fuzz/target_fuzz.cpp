#include <cstdint>
#include <string_view>

#include "calib/board.h"
#include "core/check.h"

// Whatever parses passes check(), is written and read back the same, and has finite points.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const Result<calib::TargetDesign> target = calib::parse_target(input);
  if (!target) return 0;
  FLOATSTAGE_CHECK(check(*target), "a parsed target that does not pass check()");
  const Result<calib::TargetDesign> again = calib::parse_target(calib::to_text(*target));
  FLOATSTAGE_CHECK(again && *again == *target, "a target that changes when it is written");
  for (const Eigen::Vector3d& p : calib::target_points(*target))
    FLOATSTAGE_CHECK(p.allFinite(), "a point that is not finite");
  return 0;
}
