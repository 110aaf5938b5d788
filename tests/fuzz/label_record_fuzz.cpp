#include "pipeline/label_record.h"
#include "tests/fuzz/record_fuzz.h"

// mattes/labels.json.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  claim_refused_or_kept(
      {reinterpret_cast<const char*>(data), size},
      [](const TakeLayout& layout) { return layout.label_record(); }, pipeline::load_label_record,
      pipeline::save_label_record,
      [](const pipeline::LabelRecord& a, const pipeline::LabelRecord& b) { return a == b; });
  return 0;
}
