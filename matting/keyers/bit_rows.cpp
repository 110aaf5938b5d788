// Method:  dilation by doubling: shifted copies are joined until they reach the radius; components by runs
// Paper:   M. van Droogenbroeck, H. Talbot, "Fast computation of morphological operations with arbitrary
// structuring
//          elements", 1996, for doubling; K. Wu, E. Otoo, K. Suzuki, "Optimizing two-pass connected-component
//          labeling algorithms", 2009, for runs and union by the smaller root
// Differs: rows are words of 64 pixels
// ADR:     0195

#include "matting/keyers/bit_rows.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/check.h"

namespace floatstage::matting {
namespace {

// out |= in, moved by `by` pixels (0 < by < 64) to the right or to the left. In place from the right end.
void join_right(std::uint64_t* row, std::size_t words, int by) {
  for (std::size_t w = words; w-- > 1;) row[w] |= row[w] << by | row[w - 1] >> (64 - by);
  row[0] |= row[0] << by;
}

void join_left(std::uint64_t* row, std::size_t words, int by) {
  for (std::size_t w = 0; w + 1 < words; ++w) row[w] |= row[w] >> by | row[w + 1] << (64 - by);
  row[words - 1] |= row[words - 1] >> by;
}

// Every pixel of a row grows by `radius` to both sides.
void widen(std::uint64_t* row, std::size_t words, int radius) {
  for (int reach = 0; reach < radius;) {
    const int step = std::min(reach + 1, radius - reach);
    // What reaches `reach` on both sides, joined with itself moved by `step`, reaches reach + step.
    join_right(row, words, step);
    reach += step;
  }
}

bool any(const std::uint64_t* row, std::size_t words) {
  std::uint64_t all = 0;
  for (std::size_t w = 0; w < words; ++w) all |= row[w];
  return all != 0;
}

}  // namespace

void BitRows::resize(int width, int height) {
  width_ = width;
  height_ = height;
  words_ = (static_cast<std::size_t>(width) + 63) / 64;
  bits_.resize(words_ * static_cast<std::size_t>(height));
}

void BitRows::clear() { std::fill(bits_.begin(), bits_.end(), 0); }

void BitRows::set(int y, int x0, int x1) {
  std::uint64_t* words = row(y);
  for (int x = x0; x < x1;) {
    const int bit = x % 64, count = std::min(64 - bit, x1 - x);
    words[x / 64] |= (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << bit;
    x += count;
  }
}

void BitRows::trim(int y) {
  if (width_ % 64 != 0) row(y)[words_ - 1] &= (std::uint64_t{1} << (width_ % 64)) - 1;
}

bool any_between(const std::uint64_t* row, int x0, int x1) {
  for (int x = x0; x < x1; x = (x / 64 + 1) * 64) {
    const int count = std::min(64 - x % 64, x1 - x);
    const std::uint64_t mask = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
    if ((row[x / 64] >> (x % 64) & mask) != 0) return true;
  }
  return false;
}

BitBox bounding_box(const BitRows& picture) {
  BitBox box{picture.width(), picture.height(), 0, 0};
  for (int y = 0; y < picture.height(); ++y) {
    const std::uint64_t* row = picture.row(y);
    std::size_t first = 0, last = picture.words();
    while (first < last && row[first] == 0) ++first;
    if (first == last) continue;
    while (row[last - 1] == 0) --last;
    box.x0 = std::min(box.x0, static_cast<int>(64 * first) + std::countr_zero(row[first]));
    box.x1 = std::max(box.x1, static_cast<int>(64 * last) - std::countl_zero(row[last - 1]));
    box.y0 = std::min(box.y0, y);
    box.y1 = y + 1;
  }
  return box.empty() ? BitBox{} : box;
}

BitBox grown(const BitBox& box, int by, const BitRows& limits) {
  return {std::max(box.x0 - by, 0), std::max(box.y0 - by, 0), std::min(box.x1 + by, limits.width()),
          std::min(box.y1 + by, limits.height())};
}

BitBox joined(const BitBox& a, const BitBox& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

void BitMorphology::dilate(const BitRows& in, int radius, BitRows& out) {
  FLOATSTAGE_CHECK(radius >= 0 && radius <= kMostRadius, "a radius within a word");
  const std::size_t words = in.words();
  const int height = in.height(), rows = height + 2 * radius;
  out.resize(in.width(), height);
  // Row y of the picture is row y + radius of `padded_`; what is joined to it reaches upwards.
  padded_.assign(words * static_cast<std::size_t>(rows), 0);
  for (int y = 0; y < height; ++y) {
    std::uint64_t* row = padded_.data() + words * static_cast<std::size_t>(y + radius);
    std::copy_n(in.row(y), words, row);
    if (!any(row, words)) continue;
    widen(row, words, radius);
    for (int reach = 0; reach < radius;) {
      const int step = std::min(reach + 1, radius - reach);
      join_left(row, words, step);
      reach += step;
    }
  }
  int covered = 1;
  for (const int wanted = 2 * radius + 1; covered < wanted;) {
    const int step = std::min(covered, wanted - covered);
    const std::size_t ahead = words * static_cast<std::size_t>(step), end = padded_.size() - ahead;
    for (std::size_t w = 0; w < end; ++w) padded_[w] |= padded_[w + ahead];
    covered += step;
  }
  std::copy_n(padded_.begin(), out.all().size(), out.all().begin());
  for (int y = 0; y < height; ++y) out.trim(y);
}

void BitMorphology::erode(const BitRows& in, int radius, BitRows& out) {
  inverse_.resize(in.width(), in.height());
  for (std::size_t w = 0; w < in.all().size(); ++w) inverse_.all()[w] = ~in.all()[w];
  for (int y = 0; y < in.height(); ++y) inverse_.trim(y);
  dilate(inverse_, radius, out);
  for (std::uint64_t& word : out.all()) word = ~word;
  for (int y = 0; y < in.height(); ++y) out.trim(y);
}

void BitMorphology::erode_disc(const BitRows& in, int radius, BitRows& out) {
  FLOATSTAGE_CHECK(radius > 0 && radius <= kMostRadius, "a radius within a word");
  const std::size_t words = in.words();
  const int height = in.height();
  out.resize(in.width(), height);
  out.clear();
  rows_.resize(in.width(), height);
  inverse_.resize(in.width(), height);
  int widened = -1;
  // From the narrowest row of the disc to its widest, so that rows are widened further and never anew.
  for (int dy = radius; dy >= 0; --dy) {
    const int half = static_cast<int>(
        std::lrint(radius * std::sqrt((radius * radius - dy * dy) / double(radius * radius))));
    if (widened < 0) {
      for (std::size_t w = 0; w < in.all().size(); ++w) rows_.all()[w] = ~in.all()[w];
      for (int y = 0; y < height; ++y) rows_.trim(y);
      widened = 0;
    }
    for (int y = 0; y < height; ++y) {
      std::uint64_t* row = rows_.row(y);
      for (int reach = 0; reach < half - widened;) {
        const int step = std::min(reach + 1, half - widened - reach);
        join_right(row, words, step);
        reach += step;
      }
      for (int reach = 0; reach < half - widened;) {
        const int step = std::min(reach + 1, half - widened - reach);
        join_left(row, words, step);
        reach += step;
      }
    }
    widened = std::max(widened, half);
    for (int y = 0; y < height; ++y) {
      const std::uint64_t* row = rows_.row(y);
      for (const int to : {y - dy, y + dy}) {
        if (to < 0 || to >= height) continue;
        std::uint64_t* eaten = out.row(to);
        for (std::size_t w = 0; w < words; ++w) eaten[w] |= row[w];
      }
    }
  }
  for (std::uint64_t& word : out.all()) word = ~word;
  for (int y = 0; y < height; ++y) out.trim(y);
}

int BitComponents::root(int run) {
  while (parents_[static_cast<std::size_t>(run)] != run) {
    int& parent = parents_[static_cast<std::size_t>(run)];
    parent = parents_[static_cast<std::size_t>(parent)];
    run = parent;
  }
  return run;
}

// Joins the runs [first, end) of row y with those of the row above, which begin at first_above.
void BitComponents::connect(int y, int first_above, int first, int end, bool corners) {
  const int touch = corners ? 1 : 0;
  int above = first_above;
  for (int i = first; i < end; ++i) {
    const BitRun run = runs_[static_cast<std::size_t>(i)];
    while (above < first && (runs_[static_cast<std::size_t>(above)].y < y - 1 ||
                             runs_[static_cast<std::size_t>(above)].x1 + touch <= run.x0))
      ++above;
    for (int k = above; k < first && runs_[static_cast<std::size_t>(k)].x0 < run.x1 + touch; ++k) {
      const int a = root(k), b = root(i);
      parents_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
}

void BitComponents::touching(const BitRows& core, BitRows& out) {
  touched_.assign(components_.size(), 0);
  for (const BitRun& run : runs_) {
    std::uint8_t& touched = touched_[static_cast<std::size_t>(run.component)];
    if (!touched) touched = any_between(core.row(run.y), run.x0, run.x1);
  }
  out.resize(core.width(), core.height());
  out.clear();
  for (const BitRun& run : runs_)
    if (touched_[static_cast<std::size_t>(run.component)]) out.set(run.y, run.x0, run.x1);
}

void BitComponents::find(const BitRows& picture, const BitBox& box, bool corners) {
  runs_.clear();
  parents_.clear();
  components_.clear();
  if (box.empty()) return;
  int first_above = 0;
  for (int y = box.y0; y < box.y1; ++y) {
    const std::uint64_t* row = picture.row(y);
    const int first = static_cast<int>(runs_.size());
    bool open = false;  // a run goes on at the end of the last word
    for (int w = box.x0 / 64; w <= (box.x1 - 1) / 64; ++w) {
      std::uint64_t bits = row[w];
      if (w == box.x0 / 64) bits &= ~std::uint64_t{0} << (box.x0 % 64);
      if (w == box.x1 / 64) bits &= (std::uint64_t{1} << (box.x1 % 64)) - 1;
      int at = 0;
      while (at < 64) {
        const std::uint64_t rest = (open ? ~bits : bits) >> at;
        if (rest == 0) break;
        at += std::countr_zero(rest);
        if (open)
          runs_.back().x1 = 64 * w + at;
        else
          runs_.push_back({y, 64 * w + at, box.x1, 0});
        open = !open;
      }
    }
    const int end = static_cast<int>(runs_.size());
    for (int i = first; i < end; ++i) parents_.push_back(i);
    if (y > box.y0) connect(y, first_above, first, end, corners);
    first_above = first;
  }
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    BitRun& run = runs_[i];
    const int parent = root(static_cast<int>(i));
    if (parent == static_cast<int>(i)) {
      run.component = static_cast<int>(components_.size());
      components_.push_back({0, {run.x0, run.y, run.x1, run.y + 1}});
    } else {
      run.component = runs_[static_cast<std::size_t>(parent)].component;
    }
    BitComponent& whole = components_[static_cast<std::size_t>(run.component)];
    whole.area += run.x1 - run.x0;
    whole.box = {std::min(whole.box.x0, run.x0), std::min(whole.box.y0, run.y),
                 std::max(whole.box.x1, run.x1), std::max(whole.box.y1, run.y + 1)};
  }
}

}  // namespace floatstage::matting
