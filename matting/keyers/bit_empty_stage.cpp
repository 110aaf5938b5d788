// Method:  a key corrected by the empty stage, on words of 64 pixels
// Differs: EmptyStage::correct() looks at whole pictures; here what is far from the key is not asked
// ADR:     0293, 0342

#include "matting/keyers/bit_empty_stage.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "matting/keyers/alpha_bits.h"

namespace floatstage::matting {
namespace {

// The words of bits x0 … x1 - 1 of a row, each with the mask of those.
template <class Take>
void for_words(int x0, int x1, const Take& take) {
  for (int x = x0; x < x1; x = (x / 64 + 1) * 64) {
    const int count = std::min(64 - x % 64, x1 - x);
    const std::uint64_t mask = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    take(static_cast<std::size_t>(x / 64), mask << (x % 64));
  }
}

long count_between(const std::uint64_t* row, int x0, int x1) {
  long count = 0;
  for_words(x0, x1, [&](std::size_t w, std::uint64_t mask) { count += std::popcount(row[w] & mask); });
  return count;
}

void clear_between(std::uint64_t* row, int x0, int x1) {
  for_words(x0, x1, [&](std::size_t w, std::uint64_t mask) { row[w] &= ~mask; });
}

long count_of(const BitRows& rows) {
  long count = 0;
  for (const std::uint64_t word : rows.all()) count += std::popcount(word);
  return count;
}

}  // namespace

BitEmptyStage::BitEmptyStage(const EmptyStage& stage) : stage_(stage) {
  const Image& fixtures = stage.fixtures();
  fixtures_.resize(fixtures.width, fixtures.height);
  fixtures_.clear();
  for (int y = 0; y < fixtures.height; ++y)
    for (int x = 0; x < fixtures.width; ++x)
      if (*fixtures.at(x, y) != 0) fixtures_.set(y, x, x + 1);
}

bool BitEmptyStage::correct(const PixelRows& rgb, const BitBox& part, std::uint8_t* alpha, std::size_t stride,
                            BitBox& changed) {
  part_ = part;
  if (part.empty()) return true;
  std::uint8_t* first =
      alpha + stride * static_cast<std::size_t>(part.y0) + static_cast<std::size_t>(part.x0);
  read(first, stride);
  if (take_out_fixtures(rgb, first, stride)) drop_remains(first, stride);
  find_solid(rgb);
  if (!fits_the_key()) return false;
  keep_touching();
  find_more();
  for (int y = 0; y < more_.height(); ++y)
    set_row(more_.row(y), more_.width(), 255, first + stride * static_cast<std::size_t>(y));
  if (const BitBox box = bounding_box(more_); !box.empty())
    changed = joined(changed, {part.x0 + box.x0, part.y0 + box.y0, part.x0 + box.x1, part.y0 + box.y1});
  return true;
}

// some_ and subject_.
void BitEmptyStage::read(const std::uint8_t* alpha, std::size_t stride) {
  const int width = part_.x1 - part_.x0, height = part_.y1 - part_.y0;
  for (BitRows* bits : {&some_, &subject_}) bits->resize(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = alpha + stride * static_cast<std::size_t>(y);
    bits_of_row(row, width, 1, some_.row(y));
    bits_of_row(row, width, kSubjectAlpha, subject_.row(y));
  }
}

// Where the photograph shows a fixture as the plate does. Whether there is any.
bool BitEmptyStage::take_out_fixtures(const PixelRows& rgb, std::uint8_t* alpha, std::size_t stride) {
  const std::size_t words = some_.words(), left = static_cast<std::size_t>(part_.x0) / 64;
  bool any = false;
  unlike_.resize(words);
  row_.resize(64 * words);
  gone_.resize(some_.width(), some_.height());
  gone_.clear();
  for (int y = 0; y < some_.height(); ++y) {
    const std::uint64_t* fixtures = fixtures_.row(part_.y0 + y) + left;
    std::size_t first = 0, last = words;
    while (first < last && (fixtures[first] & some_.row(y)[first]) == 0) ++first;
    while (last > first && (fixtures[last - 1] & some_.row(y)[last - 1]) == 0) --last;
    if (first == last) continue;
    const int x0 = static_cast<int>(64 * first), x1 = std::min(static_cast<int>(64 * last), some_.width());
    stage_.alike().opacities(rgb.at(part_.x0 + x0, part_.y0 + y), part_.x0 + x0, part_.y0 + y, x1 - x0,
                             row_.data());
    bits_of_row(row_.data(), x1 - x0, kSubjectAlpha, unlike_.data());
    for (std::size_t w = first; w < last; ++w) {
      std::uint64_t gone = fixtures[w] & some_.row(y)[w] & ~unlike_[w - first];
      any = any || gone != 0;
      gone_.row(y)[w] = gone;
      some_.row(y)[w] &= ~gone;
      subject_.row(y)[w] &= ~gone;
      for (; gone != 0; gone &= gone - 1)
        alpha[stride * static_cast<std::size_t>(y) + 64 * w +
              static_cast<std::size_t>(std::countr_zero(gone))] = 0;
    }
  }
  return any;
}

// Of a key from which something was taken, goes what hangs together with it and is no subject's part by its
// size: its edges.
void BitEmptyStage::drop_remains(std::uint8_t* alpha, std::size_t stride) {
  morphology_.dilate(gone_, 1, around_gone_);
  components_.find(some_, bounding_box(some_), true);
  areas_.assign(components_.components().size(), 0);
  touched_.assign(areas_.size(), 0);
  for (const BitRun& run : components_.runs()) {
    const auto component = static_cast<std::size_t>(run.component);
    areas_[component] += count_between(subject_.row(run.y), run.x0, run.x1);
    if (!touched_[component]) touched_[component] = any_between(around_gone_.row(run.y), run.x0, run.x1);
  }
  const long largest = areas_.empty() ? 0 : *std::max_element(areas_.begin(), areas_.end());
  const double least = stage_.smallest_island() * static_cast<double>(largest);
  for (const BitRun& run : components_.runs()) {
    const auto component = static_cast<std::size_t>(run.component);
    const long area = areas_[component];
    if (!touched_[component] || (area > 0 && static_cast<double>(area) >= least)) continue;
    std::memset(alpha + stride * static_cast<std::size_t>(run.y) + run.x0, 0,
                static_cast<std::size_t>(run.x1 - run.x0));
    clear_between(subject_.row(run.y), run.x0, run.x1);
  }
}

// seen_: what no shadow can be; solid_: EmptyStage::solid().
void BitEmptyStage::find_solid(const PixelRows& rgb) {
  const CleanupOptions& cleanup = EmptyStage::solid_clean_up();
  closing_.resize(some_.width(), some_.height());
  for (BitRows* bits : {&seen_, &solid_, &solid_faint_}) bits->resize(some_.width(), some_.height());
  for (int y = 0; y < some_.height(); ++y)
    stage_.no_shadow().opacities(rgb.at(part_.x0, part_.y0 + y), part_.x0, part_.y0 + y, some_.width(),
                                 closing_.row(y));
  for (int y = 0; y < some_.height(); ++y)
    bits_of_row(closing_.row(y), some_.width(), kSubjectAlpha, seen_.row(y));
  closing_.close(cleanup.close_radius);
  for (int y = 0; y < some_.height(); ++y) {
    bits_of_row(closing_.row(y), some_.width(), kSubjectAlpha, solid_.row(y));
    std::copy_n(solid_.row(y), solid_.words(), solid_faint_.row(y));
  }
  cleaner_.run(cleanup, solid_, solid_faint_);
}

bool BitEmptyStage::fits_the_key() const {
  long alone = 0;
  for (std::size_t w = 0; w < solid_.all().size(); ++w)
    alone += std::popcount(solid_.all()[w] & ~subject_.all()[w]);
  return alone <= count_of(subject_);
}

// touching_: of solid_, what hangs together with the key's subject.
void BitEmptyStage::keep_touching() {
  components_.find(solid_, bounding_box(solid_), true);
  components_.touching(subject_, touching_);
}

// more_: what the key lacks and is no outline, and whatever is far from one.
void BitEmptyStage::find_more() {
  const Image& size = stage_.fixtures();
  const int thick = EmptyStage::outline_radius(size);
  lacks_ = touching_;
  for (std::size_t w = 0; w < lacks_.all().size(); ++w) lacks_.all()[w] &= ~subject_.all()[w];
  morphology_.erode(lacks_, thick, surrounded_);
  morphology_.dilate(surrounded_, thick, thick_);
  for (std::size_t w = 0; w < seen_.all().size(); ++w) seen_.all()[w] &= touching_.all()[w];
  morphology_.erode(seen_, thick - 1, surrounded_);
  if (!EmptyStage::tells_stripes(size)) surrounded_.clear();
  morphology_.erode(touching_, EmptyStage::rim(size), more_);
  for (std::size_t w = 0; w < more_.all().size(); ++w)
    more_.all()[w] |= thick_.all()[w] | (lacks_.all()[w] & surrounded_.all()[w]);
}

}  // namespace floatstage::matting
