// Method:  BackingField's key row by row, in vectors; specks and holes as runs of bits
// Paper:   see backing_field.cpp; minima over squares by doubling, as in bit_rows.cpp
// Differs: nothing: the bits of BackingField::distances()
// ADR:     0347

#include <algorithm>
#include <bit>
#include <cstring>

#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/cloth_kernels.h"
#include "matting/keyers/field_rows.h"

namespace floatstage::matting {
namespace {

constexpr double kLargestHole = 0.03;  // of the subject; larger ones are open

void take_less(const std::uint8_t* from, std::size_t count, std::uint8_t* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = std::min(to[i], from[i]);
}

// Minima over squares of 2 * radius + 1 pixels, of rows that come one after the other; beyond the picture
// lies nothing.
class SquareMinimum {
 public:
  SquareMinimum(int radius, int width, int height)
      : radius_(radius), height_(height), width_(static_cast<std::size_t>(width)), room_(padded(width_)) {
    ring_.resize(static_cast<std::size_t>(2 * radius + 1) * room_);
    row_.resize(width_ + 2 * static_cast<std::size_t>(radius));
  }
  // Where row y of the picture is to be written, padded() bytes.
  std::uint8_t* row(int y) { return ring_.data() + static_cast<std::size_t>(y % (2 * radius_ + 1)) * room_; }
  // Of row y, once all rows down to y + radius are there.
  const std::uint8_t* at(int y) {
    const auto r = static_cast<std::size_t>(radius_);
    std::fill(row_.begin(), row_.end(), std::uint8_t{255});
    for (int i = std::max(y - radius_, 0); i <= std::min(y + radius_, height_ - 1); ++i)
      take_less(row(i), width_, row_.data() + r);
    for (std::size_t covered = 1; covered < 2 * r + 1;) {
      const std::size_t step = std::min(covered, 2 * r + 1 - covered);
      take_less(row_.data() + step, row_.size() - step, row_.data());
      covered += step;
    }
    return row_.data();
  }

 private:
  int radius_, height_;
  std::size_t width_, room_;
  std::vector<std::uint8_t> ring_, row_;
};

// Of millions of pixels some thousand are off by chance; what is off together is a thing.
void drop_specks(const BitRows& subject, long least, Image& alpha) {
  BitComponents parts;
  parts.find(subject, bounding_box(subject), true);
  for (const BitRun& run : parts.runs())
    if (parts.components()[static_cast<std::size_t>(run.component)].area < least)
      std::memset(alpha.at(run.x0, run.y), 0, static_cast<std::size_t>(run.x1 - run.x0));
}

}  // namespace

Image BackingField::key(const Image& picture) const {
  const int w = picture.width, h = picture.height, radius = cell(w) / 2, size = 2 * radius + 1;
  const FieldKernels& kernels = field_kernels();
  const std::size_t count = static_cast<std::size_t>(w), room = padded(count);
  Rows pixels(*this, Scale::Pixel, picture, 0, w), cells(*this, Scale::Cell, picture, 0, w);
  SquareMeans means(picture, radius, {0, 0, w, h});
  SquareMinimum narrow(radius, w, h);
  Image alpha(w, h, 1);
  BitRows subject;
  subject.resize(w, h);
  std::vector<std::uint8_t> own(room * static_cast<std::size_t>(radius + 1));
  for (int y = 0; y < h + radius; ++y) {
    const auto single = [&](int row) {
      return own.data() + room * static_cast<std::size_t>(row % (radius + 1));
    };
    if (y < h) {
      kernels.mean_alphas(cells.at(y), means.next(), sigmas_, room, narrow.row(y));
      const std::uint8_t* planes[3];
      means.planes(planes);
      kernels.alphas(pixels.at(y), planes, sigmas_, room, single(y));
    }
    // The mean of a cell sees an edge half a cell before it is there.
    const int done = y - radius;
    if (done < 0) continue;
    const std::uint8_t *broad = narrow.at(done), *sharp = single(done);
    std::uint8_t* out = alpha.at(0, done);
    for (std::size_t x = 0; x < count; ++x) out[x] = std::max(sharp[x], broad[x]);
    bits_of_row(out, w, 128, subject.row(done));
  }
  drop_specks(subject, std::min<long>(std::max(4, size * size / 4), static_cast<long>(w) * h), alpha);
  return alpha;
}

void BackingField::fill_holes(const Image& picture, Image& alpha) const {
  const BitBox whole{0, 0, alpha.width, alpha.height};
  BitRows open;
  bits_of(alpha, whole, 128, open);
  long subject = 0;
  for (int y = 0; y < open.height(); ++y) {
    for (std::size_t i = 0; i < open.words(); ++i) {
      subject += std::popcount(open.row(y)[i]);
      open.row(y)[i] = ~open.row(y)[i];
    }
    open.trim(y);
  }
  BitComponents gaps;
  gaps.find(open, whole, false);
  if (gaps.components().size() < 2) return;
  // Those that may be filled, and what holds them all.
  const double largest = kLargestHole * static_cast<double>(subject);
  const auto may_be = [&](const BitComponent& gap) {
    return gap.box.x0 > 0 && gap.box.y0 > 0 && gap.box.x1 < whole.x1 && gap.box.y1 < whole.y1 &&
           static_cast<double>(gap.area) <= largest;
  };
  BitBox box{whole.x1, whole.y1, 0, 0};
  for (const BitComponent& gap : gaps.components())
    if (may_be(gap))
      box = {std::min(box.x0, gap.box.x0), std::min(box.y0, gap.box.y0), std::max(box.x1, gap.box.x1),
             std::max(box.y1, gap.box.y1)};
  if (box.empty()) return;

  std::vector<long> far(gaps.components().size(), 0);
  Rows rows(*this, Scale::Cell, picture, box.x0, box.x1);
  SquareMeans means(picture, cell(picture.width) / 2, box);
  std::vector<float> off(padded(static_cast<std::size_t>(box.x1 - box.x0)));
  auto run = gaps.runs().begin();
  for (int y = box.y0; y < box.y1; ++y) {
    field_kernels().distances(rows.at(y), means.next(), off.size(), off.data());
    while (run != gaps.runs().end() && run->y < y) ++run;
    for (; run != gaps.runs().end() && run->y == y; ++run) {
      const auto component = static_cast<std::size_t>(run->component);
      if (!may_be(gaps.components()[component])) continue;
      for (int x = run->x0; x < run->x1; ++x)
        far[component] += off[static_cast<std::size_t>(x - box.x0)] > 0.5f * sigmas_;
    }
  }
  for (const BitRun& gap : gaps.runs()) {
    const auto component = static_cast<std::size_t>(gap.component);
    const BitComponent& all = gaps.components()[component];
    if (may_be(all) && 4 * far[component] >= 3 * all.area)
      std::memset(alpha.at(gap.x0, gap.y), 255, static_cast<std::size_t>(gap.x1 - gap.x0));
  }
}

}  // namespace floatstage::matting
