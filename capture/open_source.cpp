#include <array>

#include "capture/aravis/aravis_source.h"
#include "capture/frame_source.h"
#include "capture/replay/replay_source.h"
#include "capture/synthetic/synthetic_source.h"
#include "capture/v4l2/v4l2_source.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct SourceKind {
  std::string_view scheme, usage;
  /// Gets what follows "<scheme>:", and the whole URI for its errors.
  Result<std::unique_ptr<FrameSource>> (*open)(const std::string& address, const std::string& uri);
};

// Every kind of camera: a new one is its folder, a line here and a line in frame_source_conformance_test.cpp.
constexpr std::array kKinds = {
    SourceKind{"take", kReplayUsage, &open_replay},
    SourceKind{"synthetic", kSyntheticUsage, &open_synthetic},
    SourceKind{"gige", kAravisUsage, &open_aravis},
    SourceKind{"v4l2", kV4l2Usage, &open_v4l2},
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_source(const std::string& uri) {
  const std::size_t colon = uri.find(':');
  const std::string_view scheme = std::string_view(uri).substr(0, colon);
  std::string understood;
  for (const SourceKind& kind : kKinds) {
    if (colon != std::string::npos && scheme == kind.scheme) return kind.open(uri.substr(colon + 1), uri);
    understood += text(understood.empty() ? "" : " or ", kind.usage);
  }
  return fail(ErrorCode::InvalidArgument,
              text("source '", uri, "': no camera of this kind; understood is ", understood));
}

}  // namespace floatstage::capture
