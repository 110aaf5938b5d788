#include <cstdint>
#include <string_view>

#include "calib/drift.h"
#include "core/check.h"

// Whatever parses has whole patches and is written and read back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<calib::DriftReference> reference =
      calib::parse_drift_reference({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!reference) return 0;
  for (const auto& patches : reference->patches)
    for (const calib::DriftPatch& p : patches)
      FLOATSTAGE_CHECK(p.grey.size() == static_cast<std::size_t>(calib::kDriftPatch) * calib::kDriftPatch &&
                           p.at.allFinite(),
                       "half a patch");
  const Result<calib::DriftReference> again = calib::parse_drift_reference(to_json(*reference), "again");
  FLOATSTAGE_CHECK(again && *again == *reference, "a reference that changes when it is written");
  return 0;
}
