// The photo graph on photographs (../shared/data/detail): a zoom series with measured homographies, panoramas
// and other scenes, none of which is a detail of another, and cut-outs with exact truth.

#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/jpeg.h"
#include "core/random.h"
#include "detail/photo_file.h"
#include "detail/photo_graph.h"
#include "detail/quad.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::detail {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector2d;

// What shows one subject: a folder of the series and panoramas, each file of the textures.
std::string scene_of(const std::string& name) {
  if (name.starts_with("textures/")) return name;
  return name.substr(0, name.rfind('/'));
}

int number_of(const std::string& name) { return name[name.size() - 5] - '0'; }  // bark/img4.png

// 3x3 numbers, pixel centres at whole numbers, as corners at whole numbers.
Matrix3d refined(const fs::path& file) {
  std::ifstream in(file);
  Matrix3d h;
  for (int i = 0; i < 9; ++i) in >> h(i / 3, i % 3);
  Matrix3d shift = Matrix3d::Identity();
  shift(0, 2) = shift(1, 2) = 0.5;
  return shift * h * shift.inverse();
}

double mean_corner_error(const Matrix3d& a, const Matrix3d& b, int width, int height) {
  double sum = 0;
  for (const Vector2d& corner :
       {Vector2d(0, 0), Vector2d(width, 0), Vector2d(0, height), Vector2d(width, height)})
    sum += ((a * corner.homogeneous()).hnormalized() - (b * corner.homogeneous()).hnormalized()).norm();
  return sum / 4;
}

class GraphOfPhotographs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!fs::exists(real_data("detail"))) return;
    relations_ = new Result<PhotoRelations>(relate_photos(real_data("detail"), {}));
  }
  static void TearDownTestSuite() { delete relations_; }
  void SetUp() override {
    FLOATSTAGE_NEEDS_DATA(real_data("detail"));
    ASSERT_THAT(*relations_, IsOk());
  }
  static const PhotoRelations& relations() { return **relations_; }

 private:
  static Result<PhotoRelations>* relations_;
};
Result<PhotoRelations>* GraphOfPhotographs::relations_ = nullptr;

TEST_F(GraphOfPhotographs, RelatesNoPhotographToOneOfAnotherScene) {
  const std::vector<Photo>& photos = relations().photos;
  int pairs = 0;
  for (std::size_t c = 0; c < photos.size(); ++c)
    for (std::size_t p = 0; p < photos.size(); ++p) {
      if (scene_of(photos[c].name) == scene_of(photos[p].name)) continue;
      ++pairs;
      EXPECT_FALSE(relations().pair(c, p).contained()) << photos[c].name << " in " << photos[p].name;
    }
  RecordProperty("pairs", pairs);
  EXPECT_GT(pairs, 1500);
}

TEST_F(GraphOfPhotographs, FindsEveryContainmentOfTheBarkAndNoOther) {
  const std::set<std::pair<int, int>> truth = {{1, 4}, {1, 5}, {1, 6}, {2, 4}, {2, 5},
                                               {2, 6}, {3, 5}, {3, 6}, {4, 6}, {5, 6}};
  std::set<std::pair<int, int>> found;
  const std::vector<Photo>& photos = relations().photos;
  for (std::size_t c = 0; c < photos.size(); ++c)
    for (std::size_t p = 0; p < photos.size(); ++p)
      if (c != p && photos[c].name.starts_with("bark/") && photos[p].name.starts_with("bark/")) {
        const PairRelation& r = relations().pair(c, p);
        if (r.contained()) found.emplace(number_of(photos[c].name), number_of(photos[p].name));
      }
  EXPECT_EQ(found, truth);
}

TEST_F(GraphOfPhotographs, PlacesTheClosestBarkAsMeasured) {
  const std::vector<Photo>& photos = relations().photos;
  const auto place = [&](const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(photos.begin(), photos.end(), [&](const Photo& p) { return p.name == name; }) -
        photos.begin());
  };
  const std::size_t first = place("bark/img1.png");
  for (int n = 2; n <= 6; ++n) {
    const Matrix3d truth = refined(real_data("detail") / "bark" / text("H1to", n, "_refined.txt"));
    const PairRelation& r = relations().pair(first, place(text("bark/img", n, ".png")));
    const double error = mean_corner_error(r.parent_from_child, truth, 765, 512);
    EXPECT_LE(error, n <= 3 ? 2 : 1) << n;
  }
}

TEST_F(GraphOfPhotographs, FindsNoDetailInPanoramas) {
  const std::vector<Photo>& photos = relations().photos;
  for (std::size_t c = 0; c < photos.size(); ++c)
    for (std::size_t p = 0; p < photos.size(); ++p)
      if (c != p && photos[c].name.starts_with("panorama/")) {
        const PairRelation& r = relations().pair(c, p);
        EXPECT_FALSE(r.contained()) << photos[c].name << " in " << photos[p].name << " " << r.inliers << " "
                                    << r.zoom;
      }
}

/// A cut-out of a photograph, and where its pixels lie in the parent.
struct CutOut {
  Image picture;
  Matrix3d parent_from_child;
};

std::uint8_t sample(const Image& image, double x, double y, int c) {
  const int u = static_cast<int>(std::floor(x - 0.5)), v = static_cast<int>(std::floor(y - 0.5));
  const double a = x - 0.5 - u, b = y - 0.5 - v;
  const auto at = [&](int i, int j) {
    return image.at(std::clamp(i, 0, image.width - 1), std::clamp(j, 0, image.height - 1))[c];
  };
  return static_cast<std::uint8_t>(std::lround((1 - b) * ((1 - a) * at(u, v) + a * at(u + 1, v)) +
                                               b * ((1 - a) * at(u, v + 1) + a * at(u + 1, v + 1))));
}

// Turned by up to 8 degrees, with a gamma of 0.8 to 1.25, through JPEG 85, wholly inside the photograph.
CutOut cut_out(const Image& photo, const Image& parent, double zoom, Random& random) {
  const int w = static_cast<int>(photo.width / zoom), h = static_cast<int>(photo.height / zoom);
  const double angle = random.uniform(-8, 8) * std::numbers::pi / 180,
               gamma = std::exp(random.uniform(-0.223, 0.223));
  const Vector2d half(w / 2.0, h / 2.0);
  Eigen::Matrix2d turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const Vector2d reach = turn.cwiseAbs() * half;
  const Vector2d center(random.uniform(reach.x(), photo.width - reach.x()),
                        random.uniform(reach.y(), photo.height - reach.y()));
  std::array<std::uint8_t, 256> curve{};
  for (std::size_t i = 0; i < 256; ++i)
    curve[i] = static_cast<std::uint8_t>(std::lround(255 * std::pow(static_cast<double>(i) / 255.0, gamma)));
  Image picture(w, h, 3);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const Vector2d at = center + turn * (Vector2d(x + 0.5, y + 0.5) - half);
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = curve[sample(photo, at.x(), at.y(), c)];
    }
  Matrix3d photo_from_child = Matrix3d::Identity();
  photo_from_child.topLeftCorner<2, 2>() = turn;
  photo_from_child.topRightCorner<2, 1>() = center - turn * half;
  const Matrix3d shrink = Eigen::DiagonalMatrix<double, 3>(
      static_cast<double>(parent.width) / photo.width, static_cast<double>(parent.height) / photo.height, 1);
  return {*decode_photo(encode_jpeg(picture, 85), "cut-out"), shrink * photo_from_child};
}

Image shrunk_to(const Image& photo, int width) {
  Image out(width, photo.height * width / photo.width, 3);
  cv::Mat to(out.height, out.width, CV_8UC3, out.pixels.data());
  cv::resize(cv::Mat(photo.height, photo.width, CV_8UC3, const_cast<std::uint8_t*>(photo.pixels.data())), to,
             to.size(), 0, 0, cv::INTER_AREA);
  return out;
}

TEST(CutOutsOfAPhotograph, AreFoundInItUpToEightfoldZoom) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  const Result<Image> photo = load_photo(real_data("detail/panda/panda.jpg"));
  ASSERT_THAT(photo, IsOk());
  const Image parent = shrunk_to(*photo, 1000);
  const PhotoFeatures of_parent = find_features(parent);
  for (const auto& [zoom, wanted] : {std::pair(2.0, 40), {2.8, 36}, {4.0, 35}, {8.0, 24}}) {
    Random random(static_cast<std::uint64_t>(10 * zoom));
    int found = 0;
    for (int i = 0; i < 40; ++i) {
      const CutOut cut = cut_out(*photo, parent, zoom, random);
      const PhotoFeatures child = find_features(cut.picture);
      const PairRelation r = relate(child, of_parent, nearest_both_ways(child, of_parent).of_a);
      const double e =
          r.parent_from_child.isZero()
              ? 999
              : mean_corner_error(r.parent_from_child, cut.parent_from_child, child.width, child.height);
      found += r.contained() && e <= 2;
    }
    RecordProperty(text("found at ", zoom), found);
    EXPECT_GE(found, wanted) << zoom;
  }
}

}  // namespace
}  // namespace floatstage::detail
