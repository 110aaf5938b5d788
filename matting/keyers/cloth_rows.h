#pragma once

#include "matting/keyers/cloth_measure.h"
#include "matting/keyers/row_measure.h"

// Private to the stage.
namespace floatstage::matting {

/// The chroma key of single pixels (cloth_measure.h) by rows, in vectors.
class ClothRows : public RowMeasure {
 public:
  explicit ClothRows(const ClothMeasure& measure) : measure_(measure) {}

  bool fits(int, int) const override { return true; }
  void classify(const std::uint8_t* rgb, int y, int width, std::vector<std::uint8_t>& scratch,
                std::uint64_t* subject, std::uint64_t* faint, std::uint64_t* doubt) const override;
  void opacities(const std::uint8_t* rgb, int x, int y, int count, std::uint8_t* out) const override;
  float at(const std::uint8_t* rgb, int x, int y) const override;
  void quantize(const std::uint8_t* rgb, int x, int y, int count, std::vector<std::uint8_t>& scratch,
                std::int32_t* out) const override;
  float contrast() const override { return ClothMeasure::kEdgeContrast; }
  std::string_view sought() const override { return "green or blue cloth"; }

 private:
  ClothMeasure measure_;
};

}  // namespace floatstage::matting
