#include "render/flow_dis.h"

#include <algorithm>
#include <cstring>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr int kSmallestSide = 64;  // px: DIS builds a pyramid over 8 px patches; smaller pictures are padded
constexpr int kMostScales = 6;
// Projected photographs differ by small smooth displacements: refined longer and smoothed less than OpenCV's
// presets do (5 iterations, 20, 10), the fields follow them better (measured on the temple ring). The
// iterations are FlowOptions::refinement.
constexpr float kSmoothness = 10, kGradientConstancy = 5;

class DisFlow : public FlowEstimator {
 public:
  explicit DisFlow(cv::Ptr<cv::DISOpticalFlow> dis) : dis_(std::move(dis)) {}

  Result<FlowField> estimate(const FlowImage& a, const FlowImage& b) override {
    if (a.gray == nullptr || b.gray == nullptr || a.width <= 0 || a.height <= 0)
      return fail(ErrorCode::InvalidArgument, "optical flow of an empty picture");
    if (a.width != b.width || a.height != b.height)
      return fail(ErrorCode::InvalidArgument, text("optical flow between pictures of different sizes, ",
                                                   a.width, "x", a.height, " and ", b.width, "x", b.height));
    FlowField field{a.width, a.height, {}};
    field.uv.resize(static_cast<std::size_t>(a.width) * a.height * 2);
    if (std::equal(a.gray, a.gray + static_cast<std::size_t>(a.width) * a.height, b.gray)) return field;
    cv::Mat flow;
    dis_->calc(padded(a), padded(b), flow);
    for (int y = 0; y < a.height; ++y)
      std::memcpy(field.uv.data() + static_cast<std::size_t>(y) * a.width * 2, flow.ptr<float>(y),
                  static_cast<std::size_t>(a.width) * 2 * sizeof(float));
    return field;
  }

 private:
  static cv::Mat padded(const FlowImage& image) {
    const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.gray));
    if (std::min(image.width, image.height) >= kSmallestSide) return gray;
    cv::Mat larger;
    cv::copyMakeBorder(gray, larger, 0, std::max(0, kSmallestSide - image.height), 0,
                       std::max(0, kSmallestSide - image.width), cv::BORDER_REPLICATE);
    return larger;
  }

  cv::Ptr<cv::DISOpticalFlow> dis_;
};

}  // namespace

Result<std::unique_ptr<FlowEstimator>> make_dis_flow(const FlowOptions& options) {
  int preset = 0;
  if (options.preset == "ultrafast")
    preset = cv::DISOpticalFlow::PRESET_ULTRAFAST;
  else if (options.preset == "fast")
    preset = cv::DISOpticalFlow::PRESET_FAST;
  else if (options.preset == "medium")
    preset = cv::DISOpticalFlow::PRESET_MEDIUM;
  else
    return fail(ErrorCode::InvalidArgument,
                text("unknown DIS preset '", options.preset, "'; there are: ultrafast, fast, medium"));
  if (options.finest_scale < 0 || options.finest_scale > kMostScales || options.iterations < 0 ||
      options.refinement < 0)
    return fail(ErrorCode::InvalidArgument,
                text("DIS finest scale ", options.finest_scale, ", iterations ", options.iterations,
                     " or refinement ", options.refinement, " out of range (0…", kMostScales, ", 0…, 0…)"));
  // DIS cuts its search into one stripe a thread and propagates only inside a stripe: with OpenCV's own
  // threads the result would depend on the machine. We run whole fields in parallel instead.
  cv::setNumThreads(1);
  cv::Ptr<cv::DISOpticalFlow> dis = cv::DISOpticalFlow::create(preset);
  dis->setFinestScale(options.finest_scale);
  if (preset != cv::DISOpticalFlow::PRESET_ULTRAFAST) {
    dis->setVariationalRefinementIterations(options.refinement);
    dis->setVariationalRefinementAlpha(kSmoothness);
    dis->setVariationalRefinementGamma(kGradientConstancy);
  }
  if (options.iterations > 0) dis->setGradientDescentIterations(options.iterations);
  return std::unique_ptr<FlowEstimator>(std::make_unique<DisFlow>(std::move(dis)));
}

}  // namespace floatstage::render
