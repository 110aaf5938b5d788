#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "detail/graph_json.h"
#include "detail/relation_cache.h"

// The graph's document, and what its cache keeps: refused, or written as it was read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (const Result<detail::PhotoGraph> graph = detail::graph_from_json(bytes, "fuzz", "/f")) {
    const std::string json = detail::graph_to_json(*graph, "/f");
    const Result<detail::PhotoGraph> again = detail::graph_from_json(json, "again", "/f");
    FLOATSTAGE_CHECK(again, again.error().message);
    FLOATSTAGE_CHECK(again->photos.size() == graph->photos.size(), "photographs get lost");
    FLOATSTAGE_CHECK(again->descendants(again->root) == graph->descendants(graph->root), "another tree");
    (void)detail::graph_to_dot(*graph);
  }
  if (const Result<detail::PairRows> rows = detail::pairs_from_json(bytes, "fuzz"))
    FLOATSTAGE_CHECK(detail::pairs_from_json(detail::pairs_to_json(*rows), "again")->size() == rows->size(),
                     "pairs get lost");
  (void)detail::features_from_bytes(bytes);
  return 0;
}
