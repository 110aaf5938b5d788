#include <cstdint>
#include <string>
#include <string_view>

#include "core/check.h"
#include "core/content_hash.h"
#include "pipeline/field_file.h"

// fields/<serial>/<frame>.fields. What is mutated lacks the hash at its end: with it, nothing else would be
// read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view body(reinterpret_cast<const char*>(data), size);
  (void)pipeline::decode_fields(body, "fuzz");
  const std::string whole = std::string(body) + content_hash(body);
  const Result<pipeline::FieldFile> fields = pipeline::decode_fields(whole, "fuzz");
  if (!fields) return 0;
  FLOATSTAGE_CHECK(pipeline::encode_fields(*fields) == whole,
                   "fields that are written otherwise than they were read");
  for (const pipeline::FieldFile::Neighbor& n : fields->neighbors)
    FLOATSTAGE_CHECK(
        n.uv.size() == 2 * static_cast<std::size_t>(fields->width) * static_cast<std::size_t>(fields->height),
        "a field of another size");
  return 0;
}
