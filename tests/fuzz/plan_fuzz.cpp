#include <filesystem>

#include "core/check.h"
#include "pipeline/plan/plan.h"
#include "tests/fuzz/scratch_folder.h"

// A plan's plan.json, and the same bytes as how its items ended: refused, or written so that it is read
// again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  fuzz_file("plan.json", bytes);
  const auto plan = pipeline::load_plan(fuzz_folder());
  if (plan) {
    for (const pipeline::PlanItem& item : plan->items)
      FLOATSTAGE_CHECK(plan->log(item.id).lexically_normal().parent_path() == plan->folder / "logs",
                       "an item that leads out of its plan");
    FLOATSTAGE_CHECK(pipeline::save_plan(*plan).has_value(), "a plan that is not written");
    const auto again = pipeline::load_plan(fuzz_folder());
    FLOATSTAGE_CHECK(again && again->items.size() == plan->items.size() && again->command == plan->command,
                     "a plan that changes by being written");
  }
  pipeline::Plan known;
  known.folder = fuzz_folder();
  std::filesystem::create_directories(known.folder / "items");
  fuzz_file("items/one.json", bytes);
  if (const auto result = pipeline::load_result(known, "one"); result && *result)
    FLOATSTAGE_CHECK(pipeline::save_result(known, "one", **result).has_value(), "an end that is not written");
  return 0;
}
