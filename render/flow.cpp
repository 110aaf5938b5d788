#include "render/flow.h"

#include <algorithm>

#include "core/text.h"
#include "render/flow/variational_flow.h"
#include "render/flow_dis.h"

namespace floatstage::render {

// The table of back-ends: one line each.
namespace {
struct Backend {
  const char* name;
  Result<std::unique_ptr<FlowEstimator>> (*make)(const FlowOptions&);
};
constexpr Backend kBackends[] = {{"variational", make_variational_flow}, {"dis", make_dis_flow}};
}  // namespace

Result<void> check_flow_input(std::span<const FlowImage> images, std::span<const FlowPair> pairs,
                              std::span<const FlowField> initial, std::span<const FlowField> result) {
  auto bad = [](const auto&... parts) { return fail(ErrorCode::InvalidArgument, text(parts...)); };
  for (const FlowImage& image : images) {
    if (image.gray == nullptr || image.width <= 0 || image.height <= 0)
      return bad("optical flow of an empty picture");
    if (image.width != images[0].width || image.height != images[0].height)
      return bad("optical flow between pictures of different sizes, ", images[0].width, "x", images[0].height,
                 " and ", image.width, "x", image.height);
  }
  for (const FlowPair& pair : pairs)
    if (pair.first >= images.size() || pair.second >= images.size())
      return bad("optical flow of picture ", std::max(pair.first, pair.second), " of ", images.size());
  if (result.size() != pairs.size() || (!initial.empty() && initial.size() != pairs.size()))
    return bad("optical flow of ", pairs.size(), " pairs with ", initial.size(), " initial fields into ",
               result.size());
  for (const FlowField& field : initial)
    if (!field.uv.empty() && (field.width != images[0].width || field.height != images[0].height))
      return bad("an initial field of ", field.width, "x", field.height, " for pictures of ", images[0].width,
                 "x", images[0].height);
  return {};
}

std::vector<std::uint8_t> flow_gray(const Image& picture) {
  if (picture.channels == 1) return picture.pixels;
  const auto step = static_cast<std::size_t>(picture.channels);
  std::vector<std::uint8_t> gray(picture.pixels.size() / step);
  for (std::size_t i = 0; i < gray.size(); ++i) {
    const std::uint8_t* rgb = picture.pixels.data() + i * step;
    gray[i] = static_cast<std::uint8_t>((77U * rgb[0] + 150U * rgb[1] + 29U * rgb[2] + 128U) >> 8);
  }
  return gray;
}

Result<FlowField> estimate_flow(FlowEstimator& estimator, const FlowImage& first, const FlowImage& second) {
  const FlowImage images[] = {first, second};
  const FlowPair pair{0, 1};
  FlowField field;
  if (Result<void> ok = estimator.estimate(images, {&pair, 1}, {}, 1, {&field, 1}); !ok) return forward(ok);
  return field;
}

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
