#include "pipeline/mesh_record.h"
#include "tests/fuzz/record_fuzz.h"

// meshes/hull.json.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  claim_refused_or_kept(
      {reinterpret_cast<const char*>(data), size},
      [](const TakeLayout& layout) { return layout.hull_report(); }, pipeline::load_mesh_record,
      pipeline::save_mesh_record,
      [](const pipeline::MeshRecord& a, const pipeline::MeshRecord& b) {
        return a.meshes == b.meshes && a.reports == b.reports && a.options == b.options;
      });
  return 0;
}
