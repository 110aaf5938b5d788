#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "pipeline/import/contours.h"

namespace {

using namespace floatstage;

// What was taken can be filled, and lies in its picture.
void expect_sound(const pipeline::PictureContours& picture) {
  FLOATSTAGE_CHECK(picture.width >= 1 && picture.height >= 1, "a picture without pixels");
  for (const pipeline::ContourShape& shape : picture.shapes)
    for (const std::vector<Eigen::Vector2d>& polygon : shape.polygons) {
      FLOATSTAGE_CHECK(polygon.size() >= 3, "a polygon of fewer than three points");
      for (const Eigen::Vector2d& p : polygon)
        FLOATSTAGE_CHECK(
            p.x() >= -2 && p.y() >= -2 && p.x() <= picture.width + 2 && p.y() <= picture.height + 2,
            "a point far outside");
    }
  if (picture.width <= 128 && picture.height <= 128) (void)matte_of(picture);
}

}  // namespace

// labelme's JSON and COCO's: each input is read as both.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (const auto one = pipeline::parse_labelme(input, "cam0.json", {})) expect_sound(*one);
  if (const auto many = pipeline::parse_coco(input, "instances.json", {}))
    for (const pipeline::PictureContours& picture : *many) expect_sound(picture);
  return 0;
}
