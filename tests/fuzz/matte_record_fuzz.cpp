#include <cstdint>
#include <filesystem>
#include <string_view>

#include <unistd.h>

#include "core/check.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/matte_record.h"

// Whatever mattes/made.json says, it is refused by name or comes back from a file of our own as it was.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  static const TakeLayout layout(std::filesystem::temp_directory_path() /
                                 text("floatstage-fuzz-", ::getpid()));
  std::filesystem::create_directories(layout.mattes());
  FLOATSTAGE_CHECK(write_file(layout.made_mattes(), {reinterpret_cast<const char*>(data), size}).has_value(),
                   "the folder for temporary files takes none");
  const Result<pipeline::MatteRecord> record = pipeline::load_matte_record(layout);
  if (record) {
    FLOATSTAGE_CHECK(pipeline::save_matte_record(*record, layout).has_value(),
                     "what was read is not written");
    const Result<pipeline::MatteRecord> again = pipeline::load_matte_record(layout);
    FLOATSTAGE_CHECK(again && *again == *record, "a record that changes by being written");
  } else {
    FLOATSTAGE_CHECK(record.error().message.find("made.json") != std::string::npos,
                     "a file that is not named");
  }
  std::filesystem::remove_all(layout.folder());
  return 0;
}
