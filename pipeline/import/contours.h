#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// One outline that another program drew or found: polygons in the picture's own pixels (corner convention),
/// to a fraction of one. Inside is what an odd number of them surrounds, so that one within another is a
/// hole; none crosses itself or another.
struct ContourShape {
  std::string label;
  std::vector<std::vector<Eigen::Vector2d>> polygons;
};

/// All of one picture; the subject is what any of the shapes covers. None: the subject is not in the picture.
struct PictureContours {
  std::string picture;  ///< as its file calls it; empty where the file does not say
  int width = 0, height = 0;
  std::vector<ContourShape> shapes;
};

/// Where a program has the point (0, 0).
enum class ContourOrigin {
  Corner,  ///< the corner of the picture, as labelme, CVAT and COCO's own tools
  Centre,  ///< the first pixel's centre, as OpenCV and scikit-image
};

struct ContourOptions {
  ContourOrigin origin = ContourOrigin::Corner;
  std::vector<std::string> labels = {};  ///< shapes of other labels are left out; empty: all count
};

/// labelme's file of one picture: imageWidth, imageHeight and shapes (label, points, shape_type "polygon",
/// group_id). Shapes of one label and one group_id are one. Other keys, the picture among them, are skipped.
/// BadData, with the shape's number and label: what is no polygon, has fewer than three points or no area,
/// leaves the picture by more than a pixel, or crosses itself, and where.
Result<PictureContours> parse_labelme(std::string_view json, std::string_view name_for_errors,
                                      const ContourOptions& options);

/// COCO's file of many pictures: images (id, file_name, width, height), annotations (image_id, category_id,
/// segmentation: lists x1, y1, x2, y2, …) and categories (id, name). Errors as parse_labelme(), with the
/// annotation's id; BadData for run-length masks; InvalidArgument for a label that no category has.
Result<std::vector<PictureContours>> parse_coco(std::string_view json, std::string_view name_for_errors,
                                                const ContourOptions& options);

/// The matte whose half-opacity line is the contour: to 0.05 px where the contour is straight, to 1/(3 R) px
/// more where it is a circle of R px. A pixel's opacity is its surroundings' share of subject, weighed by
/// what an edge at any angle crosses evenly over two pixels. A subject that reaches to less than a pixel from
/// the border is cut by it.
Image matte_of(const PictureContours& contours);

/// Where two edges cross that have no corner in common; nothing when none do.
std::optional<Eigen::Vector2d> crossing_of(const std::vector<std::vector<Eigen::Vector2d>>& polygons);

}  // namespace floatstage::pipeline
