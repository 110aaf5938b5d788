#include "pipeline/import/contours.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "recon/outline.h"
#include "tests/pipeline/import/contour_support.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector2d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string labelme(const std::string& shapes) {
  return R"({"imageWidth": 32, "imageHeight": 24, "shapes": [)" + shapes + "]}";
}

std::string coco(const std::string& annotations) {
  return R"({"categories": [{"id": 1, "name": "person"}, {"id": 2, "name": "chair"}],
             "images": [{"id": 7, "file_name": "a.png", "width": 32, "height": 24},
                        {"id": 8, "file_name": "b.png", "width": 32, "height": 24}],
             "annotations": [)" +
         annotations + "]}";
}

constexpr const char* kTriangle = R"({"label": "person", "points": [[4, 3], [20.5, 3], [4, 19]]})";

TEST(Contours, OfLabelmeAreItsPolygonsAndGroupsHaveHoles) {
  const auto read = parse_labelme(
      labelme(
          R"({"label": "a", "points": [[4.25, 3], [20, 3], [20, 19]], "shape_type": "polygon", "flags": {}},
                 {"label": "b", "points": [[1, 1], [9, 1], [9, 9], [1, 9]], "group_id": 3},
                 {"label": "b", "points": [[3, 3], [3, 7], [7, 7], [7, 3]], "group_id": 3},
                 {"label": "b", "points": [[1, 11], [9, 11], [9, 19], [1, 11]], "group_id": null})"),
      "x.json", {});
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->width, 32);
  EXPECT_EQ(read->height, 24);
  ASSERT_THAT(read->shapes, SizeIs(3));
  EXPECT_EQ(read->shapes[0].polygons[0][0], Vector2d(4.25, 3));
  EXPECT_THAT(read->shapes[1].polygons, SizeIs(2));
  EXPECT_THAT(read->shapes[2].polygons, ElementsAre(SizeIs(3))) << "a point that closes it counts once";
  const Image alpha = matte_of(*read);
  EXPECT_EQ(*alpha.at(10, 4), 255);
  EXPECT_EQ(*alpha.at(4, 5), 0) << "the hole";
}

TEST(Contours, OfCocoAreOfManyPictures) {
  const auto read = parse_coco(coco(
                                   R"({"image_id": 8, "category_id": 1, "iscrowd": 0, "segmentation":
               [[1, 2, 6, 0.5, 6, 3], [9, 9, 12, 9, 12, 14.5]]},
              {"image_id": 8, "category_id": 2, "segmentation": [[20, 2, 26, 0.5, 26, 3]]})"),
                               "x.json", {});
  ASSERT_THAT(read, IsOk());
  ASSERT_THAT(*read, SizeIs(2));
  EXPECT_THAT((*read)[0].shapes, IsEmpty());
  ASSERT_THAT((*read)[1].shapes, SizeIs(2));
  EXPECT_EQ((*read)[1].picture, "b.png");
  EXPECT_EQ((*read)[1].shapes[0].label, "person");
  EXPECT_EQ((*read)[1].shapes[0].polygons[1][2], Vector2d(12, 14.5));
}

TEST(Contours, OfOtherLabelsAreLeftOut) {
  const std::string two = coco(R"({"image_id": 7, "category_id": 1, "segmentation": [[1, 2, 6, 0.5, 6, 3]]},
                                  {"image_id": 7, "category_id": 2, "segmentation": {"counts": "a"}})");
  EXPECT_THAT(parse_coco(two, "x.json", {}), FailsWith(ErrorCode::BadData, "run-length"));
  const auto one = parse_coco(two, "x.json", {.labels = {"person"}});
  ASSERT_THAT(one, IsOk());
  EXPECT_THAT((*one)[0].shapes, SizeIs(1));
  EXPECT_THAT(parse_coco(two, "x.json", {.labels = {"dog"}}),
              FailsWith(ErrorCode::InvalidArgument, "no category 'dog'; it has person, chair"));
  const auto drawn =
      parse_labelme(labelme(std::string(kTriangle) +
                            R"(, {"label": "box", "points": [[1, 1], [2, 2]], "shape_type": "rectangle"})"),
                    "x.json", {.labels = {"person"}});
  ASSERT_THAT(drawn, IsOk());
  EXPECT_THAT(drawn->shapes, SizeIs(1));
}

TEST(Contours, HaveTheirOriginWhereTheirProgramHasIt) {
  const auto corner = parse_labelme(labelme(kTriangle), "x.json", {}),
             centre = parse_labelme(labelme(kTriangle), "x.json", {.origin = ContourOrigin::Centre});
  ASSERT_THAT(corner, IsOk());
  ASSERT_THAT(centre, IsOk());
  EXPECT_EQ(corner->shapes[0].polygons[0][0], Vector2d(4, 3));
  EXPECT_EQ(centre->shapes[0].polygons[0][0], Vector2d(4.5, 3.5));
}

TEST(Contours, ThatMakeNoSenseAreRefusedWithTheirShape) {
  const auto shape = [](const std::string& points) {
    return labelme(R"({"label": "person", "points": )" + points + "}");
  };
  const auto refused = [](const std::string& json, const char* why) {
    EXPECT_THAT(parse_labelme(json, "x.json", {}), FailsWith(ErrorCode::BadData, why)) << json;
  };
  refused(shape("[[1, 1], [5, 1], [NaN, 5]]"), "x.json: not JSON at byte");
  refused(shape("[[1, 1], [5, 1], [1e999, 5]]"), "x.json");
  refused(shape("[[1, 1], [5, 1], [null, 5]]"),
          "shape 0 ('person') has points that are not pairs of numbers");
  refused(shape("[[1, 1], [5, 1], [5]]"), "not pairs");
  refused(shape("[[1, 1], [5, 1], [33.5, 5]]"), "point (33.5, 5) outside its picture of 32x24");
  refused(shape("[[1, 1], [5, 1], [5, -1.5]]"), "outside its picture");
  refused(shape("[[1, 1], [5, 1]]"), "has 2 points");
  refused(shape("[[1, 1], [5, 1], [5, 1], [1, 1]]"), "has 2 points");
  refused(shape("[[1, 1], [5, 1], [9, 1]]"), "encloses nothing");
  refused(shape("[[1, 1], [9, 9], [9, 1], [1, 9]]"), "crosses itself near (5, 5)");
  refused(labelme(R"({"label": "p", "points": [[1, 1], [9, 1], [9, 9]], "group_id": 1},
                     {"label": "p", "points": [[1, 4], [9, 4], [9, 12]], "group_id": 1})"),
          "'p' crosses itself");
  refused(labelme(R"({"label": "box", "points": [[1, 1], [2, 2]], "shape_type": "rectangle"})"),
          "shape 0 ('box') is no polygon");
  refused(R"({"imageWidth": 0, "imageHeight": 24, "shapes": []})", "0x24 pixels cannot be");
  refused(R"({"imageHeight": 24, "shapes": []})", "'imageWidth' is missing");
  refused(coco(""), "give the file itself");
  EXPECT_THAT(parse_coco(labelme(kTriangle), "x.json", {}),
              FailsWith(ErrorCode::BadData, "labelme's JSON of one picture"));
  const auto refused_coco = [](const std::string& annotations, const char* why) {
    EXPECT_THAT(parse_coco(coco(annotations), "x.json", {}), FailsWith(ErrorCode::BadData, why))
        << annotations;
  };
  refused_coco(R"({"image_id": 9, "category_id": 1, "segmentation": []})", "annotation 0: is of image 9");
  refused_coco(R"({"image_id": 7, "category_id": 1, "segmentation": [[1, 2, 3, 4, 5]]})", "has 5 numbers");
  refused_coco(R"({"image_id": 7, "category_id": 1, "segmentation": [["1", 2, 3, 4, 5, 9]]})",
               "no list of numbers");
  refused_coco(R"({"image_id": 7, "category_id": 1, "segmentation": [[1, 1, 9, 9, 9, 1, 1, 9]]})",
               "(of a.png) crosses itself");
}

TEST(Contours, OfFilesThatEndEarlyAreRefused) {
  const std::string one = labelme(kTriangle),
                    many =
                        coco(R"({"image_id": 7, "category_id": 1, "segmentation": [[1, 2, 6, 0.5, 6, 3]]})");
  for (std::size_t size = 0; size < one.size(); ++size)
    EXPECT_THAT(parse_labelme(one.substr(0, size), "x.json", {}), FailsWith(ErrorCode::BadData, "x.json"))
        << size;
  for (std::size_t size = 0; size < many.size(); ++size)
    EXPECT_THAT(parse_coco(many.substr(0, size), "x.json", {}), FailsWith(ErrorCode::BadData, "x.json"))
        << size;
}

double to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  return (a + std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0) * along - p).norm();
}

/// How far the half-opacity line of the polygon's matte lies from the polygon, at most and RMS, px; points to
/// less than `near_corners` from a corner are not looked at.
struct Distance {
  double most = 0, rms = 0;
};

Distance distance_of(const std::vector<Vector2d>& polygon, double near_corners) {
  const PictureContours contours{"", 64, 64, {{"", {polygon}}}};
  const Silhouette found =
      recon::outline_of(make_matte({}, matte_of(contours)), camera_of(contours), {.tolerance = 0});
  Distance out;
  int count = 0;
  for (const Vector2d& p : found.points) {
    double nearest = 1e9, corner = 1e9;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      nearest = std::min(nearest, to_segment(p, polygon[i], polygon[(i + 1) % polygon.size()]));
      corner = std::min(corner, (p - polygon[i]).norm());
    }
    if (corner < near_corners) continue;
    out.most = std::max(out.most, nearest);
    out.rms += nearest * nearest;
    ++count;
  }
  EXPECT_GT(count, 50);
  out.rms = std::sqrt(out.rms / count);
  return out;
}

TEST(ContourMattes, HaveStraightContoursWhereTheyAreHalfOpaque) {
  for (int k = 0; k < 60; ++k) {
    const double angle = 0.0813 * k;
    const Vector2d along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
    std::vector<Vector2d> slab;
    for (const Vector2d& corner : {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1)})
      slab.push_back(Vector2d(32 + 0.017 * k, 31.8) + 23.4 * corner.x() * along + 8.77 * corner.y() * across);
    const Distance off = distance_of(slab, 3);
    EXPECT_LT(off.most, 0.05) << angle;
    EXPECT_LT(off.rms, 0.02) << angle;
  }
}

TEST(ContourMattes, HaveRoundContoursWhereTheyAreHalfOpaque) {
  for (int k = 0; k < 40; ++k) {
    const double radius = 12 + 0.437 * k;
    std::vector<Vector2d> circle;
    for (int i = 0; i < 400; ++i) {
      const double a = 2 * std::numbers::pi * i / 400;
      circle.emplace_back(32 + 0.017 * k + radius * std::cos(a), 31.8 + radius * std::sin(a));
    }
    const Distance off = distance_of(circle, 0);
    EXPECT_LT(off.most, 0.05 + 1 / (3 * radius)) << radius;
    EXPECT_LT(off.rms, 0.015 + 1 / (6 * radius)) << radius;
  }
}

TEST(ContourMattes, HaveNoSeamWhereShapesTouch) {
  const PictureContours two{"",
                            32,
                            24,
                            {{"body", {{{4, 4}, {15.4, 4}, {15.4, 20}, {4, 20}}}},
                             {"arm", {{{15.4, 4}, {28, 4}, {28, 20}, {15.4, 20}}}}}};
  const Image alpha = matte_of(two);
  for (int x = 6; x < 26; ++x) EXPECT_EQ(*alpha.at(x, 12), 255) << x;
}

TEST(ContourMattes, AreCutWhereTheContourReachesTheBorder) {
  // labelme keeps points a pixel from the right and lower borders.
  const PictureContours cut{"", 32, 24, {{"body", {{{0, 4.5}, {31, 4.5}, {31, 23}, {0, 23}}}}}};
  const Image alpha = matte_of(cut);
  for (int y = 7; y < 24; ++y)
    for (int x = 0; x < 32; ++x) EXPECT_EQ(*alpha.at(x, y), 255) << x << "," << y;
  EXPECT_EQ(*alpha.at(0, 2), 0);
  EXPECT_TRUE(recon::outline_of(make_matte({}, alpha), camera_of(cut)).beyond_counts);
}

TEST(ContourMattes, AreEmptyWithoutAShape) {
  const Image alpha = matte_of({"", 8, 6, {}});
  EXPECT_THAT(alpha.pixels, testing::Each(0));
  EXPECT_THAT(matte_of({"", 1, 1, {}}).pixels, ElementsAre(0));
}

}  // namespace
}  // namespace floatstage::pipeline
