#include <cstdint>
#include <filesystem>
#include <string_view>

#include <unistd.h>

#include "core/check.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/mesh_record.h"

// Whatever meshes/hull.json says, it is refused by name or comes back from a file of our own as it was.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  static const TakeLayout layout(std::filesystem::temp_directory_path() /
                                 text("floatstage-fuzz-", ::getpid()));
  std::filesystem::create_directories(layout.meshes());
  FLOATSTAGE_CHECK(write_file(layout.hull_report(), {reinterpret_cast<const char*>(data), size}).has_value(),
                   "the folder for temporary files takes none");
  const Result<pipeline::MeshRecord> record = pipeline::load_mesh_record(layout);
  if (record) {
    FLOATSTAGE_CHECK(pipeline::save_mesh_record(*record, layout).has_value(), "what was read is not written");
    const Result<pipeline::MeshRecord> again = pipeline::load_mesh_record(layout);
    FLOATSTAGE_CHECK(again && again->meshes == record->meshes && again->reports == record->reports &&
                         again->options == record->options,
                     "a record that changes by being written");
  } else {
    FLOATSTAGE_CHECK(record.error().message.find("hull.json") != std::string::npos,
                     "a file that is not named");
  }
  std::filesystem::remove_all(layout.folder());
  return 0;
}
