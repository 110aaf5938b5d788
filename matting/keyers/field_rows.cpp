#include "matting/keyers/field_rows.h"

#include <algorithm>

#include "matting/keyers/cloth_kernels.h"

namespace floatstage::matting {

BackingField::Rows::Rows(const BackingField& field, Scale scale, const Image& picture, int x0, int x1)
    : field_(field), scale_(scale), height_(picture.height), terms_(FieldRow::kTerms * field.stride() + 64) {
  const std::size_t count = static_cast<std::size_t>(x1 - x0);
  cells_.resize(padded(count));
  shares_.resize(padded(count));
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const int x = x0 + static_cast<int>(std::min(i, count - 1));
    const float at = std::clamp(
        (static_cast<float>(x) + 0.5f) * static_cast<float>(field.cols_) / static_cast<float>(picture.width) -
            0.5f,
        0.0f, static_cast<float>(field.cols_ - 1));
    cells_[i] = static_cast<std::int32_t>(at);
    shares_[i] = at - static_cast<float>(cells_[i]);
  }
  row_.terms = terms_.data();
  row_.stride = field.stride();
  row_.cells = cells_.data();
  row_.shares = shares_.data();
  row_.narrow = picture.width < field.cols_;
  row_.darker_too = field.darker_too_;
}

const FieldRow& BackingField::Rows::at(int y) {
  const int last = field_.rows_ - 1;
  const float at = std::clamp(
      (static_cast<float>(y) + 0.5f) * static_cast<float>(field_.rows_) / static_cast<float>(height_) - 0.5f,
      0.0f, static_cast<float>(last));
  const int y0 = static_cast<int>(at), y1 = std::min(y0 + 1, last);
  const float share = at - static_cast<float>(y0);
  field_kernels().between(field_.terms(scale_, y0), field_.terms(scale_, y1), share,
                          FieldRow::kTerms * field_.stride(), terms_.data());
  const float* known =
      field_.known_.data() + static_cast<std::size_t>(share < 0.5f ? y0 : y1) * field_.stride();
  const bool everywhere = std::find(known, known + field_.cols_, 0.0f) == known + field_.cols_;
  row_.known = everywhere ? nullptr : known;
  return row_;
}

SquareSums::SquareSums(const Image& picture, int radius, const BitBox& box)
    : picture_(picture),
      radius_(radius),
      x0_(box.x0),
      x1_(box.x1),
      left_(std::max(box.x0 - radius, 0)),
      right_(std::min(box.x1 + radius, picture.width)),
      y_(box.y0),
      room_(padded(static_cast<std::size_t>(right_ - left_)) + 64) {
  ring_.resize(static_cast<std::size_t>(2 * radius + 2) * 3 * room_);
  columns_.resize(3 * room_);
  sums_.resize(3 * padded(static_cast<std::size_t>(x1_ - x0_)));
}

std::size_t SquareSums::slot(int y) const {
  return static_cast<std::size_t>(y % (2 * radius_ + 2)) * 3 * room_;
}

void SquareSums::load(int y) {
  std::uint8_t* to = ring_.data() + slot(y);
  cloth_kernels().split(picture_.at(left_, y), static_cast<std::size_t>(right_ - left_), to, to + room_,
                        to + 2 * room_);
}

FieldColors SquareSums::next() {
  const int last = picture_.height - 1;
  const auto add = [&](int y) {
    const std::uint8_t* from = ring_.data() + slot(std::clamp(y, 0, last));
    for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i] += from[i];
  };
  if (!begun_) {
    begun_ = true;
    for (int y = std::max(y_ - radius_, 0); y <= std::min(y_ + radius_, last); ++y) load(y);
    for (int y = y_ - radius_; y <= y_ + radius_; ++y) add(y);
  } else {
    const int in = y_ + radius_, out = y_ - radius_ - 1;
    if (in <= last) load(in);
    const std::uint8_t *more = ring_.data() + slot(std::min(in, last)),
                       *less = ring_.data() + slot(std::max(out, 0));
    field_kernels().slide(more, less, columns_.size(), columns_.data());
  }
  ++y_;
  FieldColors colors;
  const int size = 2 * radius_ + 1, end = right_ - left_ - 1, first = x0_ - left_, count = x1_ - x0_;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t* from = columns_.data() + k * room_;
    std::uint32_t* to = sums_.data() + k * (sums_.size() / 3);
    std::uint32_t sum = 0;
    for (int i = first - radius_; i <= first + radius_; ++i) sum += from[std::clamp(i, 0, end)];
    int x = 0;
    const auto slide = [&](int until) {
      for (; x < until; ++x) {
        to[x] = sum;
        sum += from[std::min(first + x + radius_ + 1, end)] - from[std::max(first + x - radius_, 0)];
      }
    };
    slide(std::min(radius_, count));
    for (const int calm = std::min(count, end - first - radius_); x < calm; ++x) {
      to[x] = sum;
      sum += from[first + x + radius_ + 1] - from[first + x - radius_];
    }
    slide(count);
    colors.sums[k] = to;
  }
  colors.count = static_cast<float>(size * size);
  return colors;
}

void SquareSums::planes(int y, const std::uint8_t* out[3]) const {
  const std::uint8_t* from = ring_.data() + slot(y) + (x0_ - left_);
  for (std::size_t k = 0; k < 3; ++k) out[k] = from + k * room_;
}

}  // namespace floatstage::matting
