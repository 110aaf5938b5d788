#include "render/flow_trust.h"

#include <algorithm>
#include <cmath>

#include "render/flow/gray_samples.h"

namespace floatstage::render {
namespace {

constexpr float kUsualRoundTrip = 0.7F;  // px by which the way there and back misses: believed half
constexpr float kUsualResidual = 10;     // 8-bit steps, mean over a neighbourhood: the same
constexpr int kNeighborhood = 2;         // px to each side
constexpr int kAcross = 2 * kNeighborhood + 1;

}  // namespace

float* FlowTrust::row(std::vector<float>& rows, int y) const {
  return rows.data() + static_cast<std::size_t>((y + kAcross) % kAcross) * static_cast<std::size_t>(width_);
}

// How far image `to`, as it is and fetched along the flow, is from image `from`: summed over a neighbourhood
// along row y, as far as that reaches into the proxy's rows. Beyond the picture's border nothing differs (a
// little trusting).
void FlowTrust::differ(const ProjectedImages& images, std::size_t from, std::size_t to,
                       const FlowField& there, int y) {
  float *before = row(before_, y), *after = row(after_, y);
  std::fill_n(before, width_, 0.F);
  std::fill_n(after, width_, 0.F);
  if (y < 0 || y >= height_) return;
  // Rows above and below ask for what is left and right of this row's own span too.
  Span span{width_, 0};
  for (int k = std::max(0, y - kNeighborhood); k <= std::min(height_ - 1, y + kNeighborhood); ++k) {
    const Span& other = spans_[static_cast<std::size_t>(k)];
    if (other.begin >= other.end) continue;
    span.begin = std::min(span.begin, other.begin);
    span.end = std::max(span.end, other.end);
  }
  if (span.begin >= span.end) return;
  const int first = std::max(0, span.begin - kNeighborhood),
            last = std::min(width_, span.end + kNeighborhood);
  const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  const std::uint8_t *a = images.gray[from].data() + line, *b = images.gray[to].data() + line;
  const float* uv = there.uv.data() + 2 * line;
  // Two pixels of nothing at either end.
  float *still = apart_[0].data() + kNeighborhood, *moved = apart_[1].data() + kNeighborhood;
  for (const int side : {first - kNeighborhood, last})
    for (int x = side; x < side + kNeighborhood; ++x) still[x] = moved[x] = 0;
  for (int x = first; x < last; ++x) still[x] = static_cast<float>(std::abs(a[x] - b[x]));
  for (int x = first; x < last; ++x)
    moved[x] = std::abs(static_cast<float>(a[x]) - bilinear_sample(images.gray[to].data(), width_, height_,
                                                                   static_cast<float>(x) + uv[2 * x],
                                                                   static_cast<float>(y) + uv[2 * x + 1]));
  for (int x = span.begin; x < span.end; ++x) {
    before[x] = still[x - 2] + still[x - 1] + still[x] + still[x + 1] + still[x + 2];
    after[x] = moved[x - 2] + moved[x - 1] + moved[x] + moved[x + 1] + moved[x + 2];
  }
}

void FlowTrust::judge(const ProjectedImages& images, std::size_t from, std::size_t to, const FlowField& there,
                      const FlowField* back, int y) {
  const Span span = spans_[static_cast<std::size_t>(y)];
  const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  const std::uint8_t *start = images.state[from].data() + line, *end = images.state[to].data();
  const float *before[kAcross], *after[kAcross];
  for (int k = 0; k < kAcross; ++k) {
    before[k] = row(before_, y - kNeighborhood + k);
    after[k] = row(after_, y - kNeighborhood + k);
  }
  constexpr float kMost = kUsualResidual * kAcross * kAcross;
  for (int x = span.begin; x < span.end; ++x) {
    if (start[x] != ProjectedImages::kOwn || end[line + static_cast<std::size_t>(x)] != ProjectedImages::kOwn)
      continue;
    float still = 0, moved = 0;
    for (int k = 0; k < kAcross; ++k) {
      still += before[k][x];
      moved += after[k][x];
    }
    float confidence = confidence_left(moved, kMost) * confidence_left(moved, still);
    if (confidence <= 0) continue;
    const std::size_t i = line + static_cast<std::size_t>(x);
    const float u = there.uv[2 * i], v = there.uv[2 * i + 1];
    const float tx = static_cast<float>(x) + u + 0.5F, ty = static_cast<float>(y) + v + 0.5F;
    if (!(tx >= 0 && ty >= 0 && tx < static_cast<float>(width_) && ty < static_cast<float>(height_)))
      continue;
    const std::size_t t =
        static_cast<std::size_t>(ty) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(tx);
    if (end[t] != ProjectedImages::kOwn) continue;
    if (back != nullptr) {
      const float home_u = u + back->uv[2 * t], home_v = v + back->uv[2 * t + 1];
      confidence *= confidence_left(std::sqrt(home_u * home_u + home_v * home_v), kUsualRoundTrip);
    }
    believed_[i] = static_cast<std::uint8_t>(255 * confidence + 0.5F);
  }
}

const std::vector<std::uint8_t>& FlowTrust::run(const ProjectedImages& images, std::size_t from,
                                                std::size_t to, const FlowField& there,
                                                const FlowField* back) {
  width_ = images.width;
  height_ = images.height;
  const auto width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
  believed_.assign(width * height, 0);
  spans_.resize(height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* state = images.state[from].data() + y * width;
    int begin = 0, end = width_;
    while (begin < end && state[begin] == ProjectedImages::kNoProxy) ++begin;
    while (end > begin && state[end - 1] == ProjectedImages::kNoProxy) --end;
    spans_[y] = {begin, end};
  }
  for (std::vector<float>& apart : apart_) apart.resize(width + 2 * kNeighborhood);
  before_.resize(kAcross * width);
  after_.resize(kAcross * width);
  for (int y = -kNeighborhood; y < kNeighborhood; ++y) differ(images, from, to, there, y);
  for (int y = 0; y < height_; ++y) {
    differ(images, from, to, there, y + kNeighborhood);
    judge(images, from, to, there, back, y);
  }
  return believed_;
}

}  // namespace floatstage::render
