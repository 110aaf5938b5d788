#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "core/matte_edits.h"

// Whatever parses is written as a document that parses to the same, and paints into any picture.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<MatteEdits> edits = parse_matte_edits({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!edits) return 0;
  const Result<MatteEdits> again = parse_matte_edits(to_json(*edits), "again");
  FLOATSTAGE_CHECK(again, "what we wrote does not parse: " + again.error().message);
  FLOATSTAGE_CHECK(*again == *edits, "changed by a round trip");
  Image map(16, 12, 1, 128);
  for (const auto& [serial, camera] : edits->cameras) {
    for (const MatteKeyframe& k : camera.keyframes) paint_strokes(k.strokes, 0.5, map);
    paint_masks(camera.masks, 3, 0.5, map);
  }
  return 0;
}
