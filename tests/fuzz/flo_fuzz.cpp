#include <cstdint>
#include <span>

#include "core/check.h"
#include "render/flow/flo_file.h"
#include "render/flow/flow_score.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const auto bytes = std::as_bytes(std::span(data, size));
  const Result<render::FlowField> field = render::decode_flo(bytes, "fuzz");
  if (!field) return 0;
  const std::string again = render::encode_flo(*field);
  FLOATSTAGE_CHECK(again.size() == size &&
                       std::equal(again.begin(), again.end(), data,
                                  [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }),
                   "a field that is written otherwise than it was read");
  const Image picture = render::flow_picture(*field);
  FLOATSTAGE_CHECK(picture.width == field->width && picture.height == field->height,
                   "a picture of another size");
  const Result<render::FlowScore> score = render::score_flow(*field, *field);
  FLOATSTAGE_CHECK(score && (score->known == 0 || score->epe == 0), "a field that is not its own truth");
  return 0;
}
