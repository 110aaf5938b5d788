#include "render/flow.h"

#include "core/text.h"
#include "render/flow_dis.h"

namespace floatstage::render {

// The table of back-ends: one line each.
namespace {
struct Backend {
  const char* name;
  Result<std::unique_ptr<FlowEstimator>> (*make)(const FlowOptions&);
};
constexpr Backend kBackends[] = {{"dis", make_dis_flow}};
}  // namespace

Result<std::unique_ptr<FlowEstimator>> make_flow_estimator(const FlowOptions& options) {
  for (const Backend& backend : kBackends)
    if (options.backend == backend.name) return backend.make(options);
  std::string known;
  for (const Backend& backend : kBackends) known += text(known.empty() ? "" : ", ", backend.name);
  return fail(ErrorCode::InvalidArgument,
              text("unknown flow back-end '", options.backend, "'; there is: ", known));
}

std::vector<std::string> flow_backends() {
  std::vector<std::string> names;
  for (const Backend& backend : kBackends) names.emplace_back(backend.name);
  return names;
}

}  // namespace floatstage::render
