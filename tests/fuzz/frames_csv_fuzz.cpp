#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "core/take_layout.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<std::vector<FrameRow>> rows =
      parse_frames_csv({reinterpret_cast<const char*>(data), size}, 2, "fuzz");
  if (!rows) return 0;
  std::string written = frames_csv_header();
  for (const FrameRow& row : *rows) written += to_csv(row);
  const Result<std::vector<FrameRow>> again = parse_frames_csv(written, 2, "again");
  FLOATSTAGE_CHECK(again, "what we wrote does not parse: " + again.error().message);
  FLOATSTAGE_CHECK(*again == *rows, "changed by a round trip");
  return 0;
}
