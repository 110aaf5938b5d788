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

SquareMeans::SquareMeans(const Image& picture, int radius, const BitBox& box)
    : picture_(picture),
      radius_(radius),
      x0_(box.x0),
      x1_(box.x1),
      left_(std::max(box.x0 - radius, 0)),
      right_(std::min(box.x1 + radius, picture.width)),
      y_(box.y0 - 1),
      missing_(static_cast<std::size_t>(left_ - (box.x0 - radius))),
      room_(padded(static_cast<std::size_t>(box.x1 - box.x0 + 2 * radius)) + 64) {
  ring_.resize(static_cast<std::size_t>(2 * radius + 2) * 3 * room_);
  columns_.resize(3 * room_);
  means_.size = 2 * radius + 1;
  for (std::size_t k = 0; k < 3; ++k) means_.columns[k] = columns_.data() + k * room_;
}

std::size_t SquareMeans::slot(int y) const {
  return static_cast<std::size_t>(y % (2 * radius_ + 2)) * 3 * room_;
}

void SquareMeans::load(int y) {
  std::uint8_t* to = ring_.data() + slot(y) + missing_;
  const std::uint8_t* from = picture_.at(left_, y);
  const std::size_t count = static_cast<std::size_t>(right_ - left_), lacking = room_ - missing_ - count;
  cloth_kernels().split(from, count, to, to + room_, to + 2 * room_);
  for (std::size_t k = 0; k < 3; ++k) {
    std::uint8_t* plane = to + k * room_;
    std::fill_n(plane - missing_, missing_, plane[0]);
    std::fill_n(plane + count, lacking, plane[count - 1]);
  }
}

const FieldMeans& SquareMeans::next() {
  const int last = picture_.height - 1;
  ++y_;
  if (!begun_) {
    begun_ = true;
    for (int y = std::max(y_ - radius_, 0); y <= std::min(y_ + radius_, last); ++y) load(y);
    for (int y = y_ - radius_; y <= y_ + radius_; ++y) {
      const std::uint8_t* from = ring_.data() + slot(std::clamp(y, 0, last));
      for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i] += from[i];
    }
  } else {
    const int in = y_ + radius_, out = y_ - radius_ - 1;
    if (in <= last) load(in);
    const std::uint8_t *more = ring_.data() + slot(std::min(in, last)),
                       *less = ring_.data() + slot(std::max(out, 0));
    field_kernels().slide(more, less, columns_.size(), columns_.data());
  }
  return means_;
}

void SquareMeans::planes(const std::uint8_t* out[3]) const {
  const std::uint8_t* from = ring_.data() + slot(y_) + radius_;
  for (std::size_t k = 0; k < 3; ++k) out[k] = from + k * room_;
}

}  // namespace floatstage::matting
