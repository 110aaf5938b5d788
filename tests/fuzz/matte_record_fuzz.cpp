#include "pipeline/matte_record.h"
#include "tests/fuzz/record_fuzz.h"

// mattes/made.json.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  claim_refused_or_kept(
      {reinterpret_cast<const char*>(data), size},
      [](const TakeLayout& layout) { return layout.made_mattes(); }, pipeline::load_matte_record,
      pipeline::save_matte_record,
      [](const pipeline::MatteRecord& a, const pipeline::MatteRecord& b) { return a == b; });
  return 0;
}
