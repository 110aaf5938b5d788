#include "render/flow/picture_pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/flow/picture_filters.h"

namespace floatstage::render {
namespace {

// How far the smoothness reaches across the proxy's outline: the band has no data and follows what it
// touches, so any small number does; it must not pull back.
constexpr float kBandStiffness = 0.01F;

void load_picture(const FlowImage& picture, PictureLevel& raw) {
  resize(raw, picture.width, picture.height);
  raw.whole = picture.state == nullptr;
  const std::size_t size = raw.zone.size();
  for (std::size_t i = 0; i < size; ++i) raw.value[i] = static_cast<float>(picture.gray[i]);
  if (raw.whole) {
    std::fill(raw.zone.begin(), raw.zone.end(), std::uint8_t{PictureLevel::kDomain});
    std::fill(raw.own.begin(), raw.own.end(), std::uint8_t{255});
    return;
  }
  for (std::size_t i = 0; i < size; ++i) {
    raw.zone[i] = picture.state[i] != 0 ? PictureLevel::kDomain : PictureLevel::kOutside;
    raw.own[i] = picture.state[i] == 255 ? 255 : 0;
  }
}

void find_spans(PictureLevel& l) {
  for (int y = 0; y < l.height; ++y) {
    const std::uint8_t* row = l.zone.data() + l.at(0, y);
    int first = 0, last = l.width - 1;
    while (first <= last && row[first] == PictureLevel::kOutside) ++first;
    while (last >= first && row[last] == PictureLevel::kOutside) --last;
    SplitSpan& span = l.spans[static_cast<std::size_t>(y)];
    span = {};
    if (first > last) continue;
    span.begin = first / 2 / kSplitBlock * kSplitBlock;
    span.end = (last / 2 / kSplitBlock + 1) * kSplitBlock;
  }
}

/// Copies a row of samples as what is no evidence.
void copy_unknown(const std::uint16_t* from, std::size_t count, std::uint16_t* to) {
  for (std::size_t x = 0; x < count; ++x) to[x] = static_cast<std::uint16_t>(from[x] & 0xFFFEU);
}

}  // namespace

SampledPicture PictureLevel::sampled() const {
  const int stride = width + 2 * kSampleMargin;
  return {samples.data() + static_cast<std::ptrdiff_t>(kSampleMargin) * stride + kSampleMargin, stride, width,
          height};
}

/// The band grows by one pixel: each takes the mean of what is known around it.
void PicturePyramid::grow_band(PictureLevel& l) {
  border_.clear();
  const auto width = static_cast<std::size_t>(l.width), words = (width + 7) / 8;
  bytes_.assign(8 * words + 16 + width, 0);
  std::uint8_t *near = bytes_.data() + 8, *joins = near + width + 8;
  for (int y = 0; y < l.height; ++y) {
    const std::uint8_t* here = l.zone.data() + l.at(0, y);
    const std::uint8_t *above = y > 0 ? here - width : here, *below = y + 1 < l.height ? here + width : here;
    for (std::size_t x = 0; x < width; ++x) near[x] = here[x] | above[x] | below[x];
    for (std::size_t x = 0; x < width; ++x)
      joins[x] = static_cast<std::uint8_t>(here[x] == PictureLevel::kOutside) &
                 static_cast<std::uint8_t>((near[x - 1] | near[x] | near[x + 1]) != 0);
    for (std::size_t word = 0; word < words; ++word) {
      std::uint64_t any = 0;
      std::memcpy(&any, joins + 8 * word, std::min<std::size_t>(8, width - 8 * word));
      if (any == 0) continue;
      for (std::size_t x = 8 * word; x < std::min(8 * word + 8, width); ++x)
        if (joins[x] != 0) border_.push_back(static_cast<int>(l.at(static_cast<int>(x), y)));
    }
  }
  for (const int i : border_) l.value[static_cast<std::size_t>(i)] = mean_of_known(l, i);
  for (const int i : border_) l.zone[static_cast<std::size_t>(i)] = PictureLevel::kBand;
}

/// Rounds to 1/128 and lays out for both parts that a picture plays.
void PicturePyramid::lay_out(PictureLevel& l, std::vector<float>& row) {
  const auto width = static_cast<std::size_t>(l.width), height = static_cast<std::size_t>(l.height);
  const std::size_t stride = width + 2 * kSampleMargin;
  l.samples.resize(stride * (height + 2 * kSampleMargin));
  l.first.resize(l.width, l.height);
  l.data.resize(l.width, l.height);
  row.resize(width);
  for (int y = 0; y < l.height; ++y) {
    const float* value = l.value.data() + l.at(0, y);
    const std::uint8_t* own = l.own.data() + l.at(0, y);
    std::uint16_t* out = l.samples.data() + (static_cast<std::size_t>(y) + kSampleMargin) * stride;
    for (std::size_t x = 0; x < width; ++x) {
      const int q = static_cast<int>(value[x] * 128.F + 0.5F);
      row[x] = static_cast<float>(q);
      out[x + kSampleMargin] = static_cast<std::uint16_t>(2 * q + (own[x] >> 7));
    }
    std::fill_n(out, kSampleMargin, static_cast<std::uint16_t>(out[kSampleMargin] & 0xFFFEU));
    std::fill_n(out + kSampleMargin + width, kSampleMargin,
                static_cast<std::uint16_t>(out[kSampleMargin + width - 1] & 0xFFFEU));
    split_row(row.data(), l.width, 1.F / 128, l.first.row(y));
    split_row(own, l.width, 1.F / 255, l.data.row(y));
  }
  std::uint16_t *top = l.samples.data() + kSampleMargin * stride, *bottom = top + (height - 1) * stride;
  for (std::size_t k = 1; k <= kSampleMargin; ++k) {
    copy_unknown(top, stride, top - k * stride);
    copy_unknown(bottom, stride, bottom + k * stride);
  }
}

void PicturePyramid::find_stiffness(PictureLevel& l, const PyramidOptions& options, std::vector<float>& row) {
  l.stiffness.resize(l.width, l.height);
  const float of_zone[3] = {0, options.stiffness * kBandStiffness, options.stiffness};
  const float per_edge = 0.5F / options.edge;
  const auto width = static_cast<std::size_t>(l.width);
  row.resize(width);
  for (int y = 0; y < l.height; ++y) {
    const float* here = l.value.data() + l.at(0, y);
    const float *above = y > 0 ? here - width : here, *below = y + 1 < l.height ? here + width : here;
    auto edge = [&](std::size_t left, std::size_t x, std::size_t right) {
      const float dx = here[right] - here[left], dy = below[x] - above[x];
      return 1.F / (1.F + std::sqrt(dx * dx + dy * dy) * per_edge);
    };
    row[0] = edge(0, 0, std::min<std::size_t>(1, width - 1));
    for (std::size_t x = 1; x + 1 < width; ++x) row[x] = edge(x - 1, x, x + 1);
    if (width > 1) row[width - 1] = edge(width - 2, width - 1, width - 1);
    if (l.whole) {
      split_row(row.data(), l.width, options.stiffness, l.stiffness.row(y));
      continue;
    }
    const std::uint8_t* zone = l.zone.data() + l.at(0, y);
    for (std::size_t x = 0; x < width; ++x) row[x] *= of_zone[zone[x]];
    split_row(row.data(), l.width, 1, l.stiffness.row(y));
  }
}

void PicturePyramid::shrink(const FlowImage& picture, int levels) {
  levels_.resize(std::max(levels_.size(), static_cast<std::size_t>(levels)));
  rows_.resize(levels_.size());
  load_picture(picture, raw_);
  for (int l = 0; l < levels; ++l) {
    const auto at = static_cast<std::size_t>(l);
    PictureLevel& to = levels_[at];
    if (l == 0)
      smooth(raw_, to, rows_[at]);
    else
      halve(levels_[at - 1], to, rows_[at]);
    for (int k = 0; k < PictureLevel::kBandWidth && !to.whole; ++k) grow_band(to);
    find_spans(to);
  }
}

void PicturePyramid::finish(int level, const PyramidOptions& options) {
  const auto at = static_cast<std::size_t>(level);
  lay_out(levels_[at], rows_[at]);
  find_stiffness(levels_[at], options, rows_[at]);
}

void PicturePyramid::build(const FlowImage& picture, int levels, const PyramidOptions& options) {
  shrink(picture, levels);
  for (int l = 0; l < levels; ++l) finish(l, options);
}

int pyramid_levels(int width, int height, int least) {
  int levels = 1;
  for (int side = std::min(width, height); (side + 1) / 2 >= least; side = (side + 1) / 2) ++levels;
  return levels;
}

}  // namespace floatstage::render
