#include "capture/manifest_file.h"

#include "core/file.h"
#include "core/text.h"

namespace floatstage::capture {

Result<TakeManifest> load_manifest(const TakeLayout& layout) {
  const Result<std::string> bytes = read_file(layout.manifest());
  if (!bytes && bytes.error().code == ErrorCode::NotFound)
    return fail(ErrorCode::NotFound, text(layout.folder().string(), " is no take: it has no take.json"));
  if (!bytes) return forward(bytes);
  return parse_manifest(*bytes, layout.manifest().string());
}

}  // namespace floatstage::capture
