#include "render/flow_dis.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/parallel.h"
#include "core/text.h"
#include "render/image_fill.h"

namespace floatstage::render {
namespace {

// Before main(), because OpenCV takes its threads apart while others work in them (docs/adr/0339). DIS cuts
// its search into one stripe a thread and propagates only inside a stripe: with OpenCV's own threads the
// result would depend on the machine. We run whole fields in parallel instead.
[[maybe_unused]] const bool kOpenCvOnOneThread = (cv::setNumThreads(1), true);

constexpr int kSmallestSide = 64;  // px: DIS builds a pyramid over 8 px patches; smaller pictures are padded
constexpr int kMostScales = 6;
// Projected photographs differ by small smooth displacements: refined longer and smoothed less than OpenCV's
// presets do (5 iterations, 20, 10), the fields follow them better (measured on the temple ring). The
// iterations are FlowOptions::refinement.
constexpr float kSmoothness = 10, kGradientConstancy = 5;

/// A picture as DIS takes it: continued beyond its content, so that the content's outline is no edge, and
/// padded where it is too small for DIS.
class DisPicture {
 public:
  void load(const FlowImage& image) {
    const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.gray));
    gray.copyTo(picture_);
    if (image.state != nullptr) continue_beyond_content(image);
    if (std::min(image.width, image.height) < kSmallestSide)
      cv::copyMakeBorder(picture_, picture_, 0, std::max(0, kSmallestSide - image.height), 0,
                         std::max(0, kSmallestSide - image.width), cv::BORDER_REPLICATE);
  }
  const cv::Mat& picture() const { return picture_; }

 private:
  void continue_beyond_content(const FlowImage& image) {
    const std::size_t size = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    values_.assign(image.gray, image.gray + size);
    known_.resize(size);
    std::transform(image.state, image.state + size, known_.begin(),
                   [](std::uint8_t state) { return state != 0 ? std::uint8_t{255} : std::uint8_t{0}; });
    fill_.run(image.width, image.height, 1, known_.data(), values_.data());
    std::uint8_t* gray = picture_.ptr<std::uint8_t>();
    for (std::size_t i = 0; i < size; ++i)
      if (image.state[i] == 0)
        gray[i] = static_cast<std::uint8_t>(std::clamp(std::lround(values_[i]), 0L, 255L));
  }

  cv::Mat picture_;
  PictureFill fill_;
  std::vector<std::uint8_t> known_;
  std::vector<float> values_;
};

class DisFlow : public FlowEstimator {
 public:
  explicit DisFlow(const FlowOptions& options, int preset) : options_(options), preset_(preset) {}

  Result<void> estimate(std::span<const FlowImage> images, std::span<const FlowPair> pairs,
                        std::span<const FlowField> initial, int threads,
                        std::span<FlowField> result) override {
    if (Result<void> ok = check_flow_input(images, pairs, initial, result); !ok) return ok;
    pictures_.resize(std::max(pictures_.size(), images.size()));
    parallel_for(images.size(), threads, [&](std::size_t i) { pictures_[i].load(images[i]); });
    const std::size_t workers =
        std::min(pairs.size(), static_cast<std::size_t>(threads > 0 ? threads : default_threads()));
    while (solvers_.size() < workers) solvers_.push_back(make());
    std::atomic<std::size_t> next = 0;
    parallel_for(workers, threads, [&](std::size_t worker) {
      for (std::size_t i; (i = next.fetch_add(1)) < pairs.size();) {
        const FlowField* from = initial.empty() || initial[i].uv.empty() ? nullptr : &initial[i];
        solve(*solvers_[worker], images[pairs[i].first], images[pairs[i].second], pairs[i], from, result[i]);
      }
    });
    return {};
  }

 private:
  cv::Ptr<cv::DISOpticalFlow> make() const {
    cv::Ptr<cv::DISOpticalFlow> dis = cv::DISOpticalFlow::create(preset_);
    dis->setFinestScale(options_.finest_scale);
    if (preset_ != cv::DISOpticalFlow::PRESET_ULTRAFAST) {
      dis->setVariationalRefinementIterations(options_.refinement);
      dis->setVariationalRefinementAlpha(kSmoothness);
      dis->setVariationalRefinementGamma(kGradientConstancy);
    }
    if (options_.iterations > 0) dis->setGradientDescentIterations(options_.iterations);
    return dis;
  }

  void solve(cv::DISOpticalFlow& dis, const FlowImage& a, const FlowImage& b, const FlowPair& pair,
             const FlowField* initial, FlowField& field) const {
    field.width = a.width;
    field.height = a.height;
    const auto width = static_cast<std::size_t>(a.width), height = static_cast<std::size_t>(a.height);
    field.uv.assign(2 * width * height, 0.F);
    if (std::equal(a.gray, a.gray + width * height, b.gray)) return;
    const cv::Mat &first = pictures_[pair.first].picture(), &second = pictures_[pair.second].picture();
    cv::Mat flow;
    if (initial != nullptr) {
      flow = cv::Mat::zeros(first.size(), CV_32FC2);
      for (std::size_t y = 0; y < height; ++y)
        std::copy_n(initial->uv.data() + 2 * y * width, 2 * width, flow.ptr<float>(static_cast<int>(y)));
    }
    dis.calc(first, second, flow);
    for (std::size_t y = 0; y < height; ++y)
      std::copy_n(flow.ptr<float>(static_cast<int>(y)), 2 * width, field.uv.data() + 2 * y * width);
  }

  FlowOptions options_;
  int preset_;
  std::vector<DisPicture> pictures_;
  std::vector<cv::Ptr<cv::DISOpticalFlow>> solvers_;  // one a thread
};

}  // namespace

Result<std::unique_ptr<FlowEstimator>> make_dis_flow(const FlowOptions& options) {
  int preset = 0;
  if (options.preset == "ultrafast")
    preset = cv::DISOpticalFlow::PRESET_ULTRAFAST;
  else if (options.preset == "fast")
    preset = cv::DISOpticalFlow::PRESET_FAST;
  else if (options.preset == "medium" || options.preset.empty())
    preset = cv::DISOpticalFlow::PRESET_MEDIUM;
  else
    return fail(ErrorCode::InvalidArgument,
                text("unknown DIS preset '", options.preset, "'; there are: ultrafast, fast, medium"));
  if (options.finest_scale < 0 || options.finest_scale > kMostScales || options.iterations < 0 ||
      options.refinement < 0)
    return fail(ErrorCode::InvalidArgument,
                text("DIS finest scale ", options.finest_scale, ", iterations ", options.iterations,
                     " or refinement ", options.refinement, " out of range (0…", kMostScales, ", 0…, 0…)"));
  return std::unique_ptr<FlowEstimator>(std::make_unique<DisFlow>(options, preset));
}

}  // namespace floatstage::render
