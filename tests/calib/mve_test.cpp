#include <fstream>

#include "calib/formats/parsers.h"
#include "core/file.h"
#include "core/png.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

// As MVE itself writes it (View::save_meta_data: keys in the order of the alphabet, ten digits).
const std::string kMeta = R"(# MVE view meta data is stored in INI-file syntax.
# This file is generated, formatting will get lost.

[camera]
focal_length = 0.9473756552
pixel_aspect = 1
principal_point = 0.49 0.52
rotation = 0.9994262709 0.03169166677 -0.01194852579 -0.03149889699 0.9993758684 0.01599041071 0.01244783111 -0.01560487117 0.9998007499
translation = -0.4283604324 -4.741177559 -0.2027004212

[view]
id = 0
name = IMG_0191
)";

MveView view(const std::string& folder, const std::string& meta, int width = 640, int height = 480) {
  return {.folder = folder, .meta = meta, .picture = "undistorted.png", .width = width, .height = height};
}

Result<ForeignRig> mve(std::string_view meta) {
  return parse_mve({view("view_0000.mve", std::string(meta))}, "scene/views");
}

// x = K (R X + t) of MVE's Math Cookbook, by its own words: the larger side of the picture, measured in what
// the pixels really are, is 1 long; the principal point is in shares of the sides; radial factor 1 + k2 r² +
// k4 r⁴.
Eigen::Vector2d by_the_cookbook(const Eigen::Vector3d& x, double aspect, double w, double h, double k2,
                                double k4) {
  const double r[9] = {0.9994262709,  0.03169166677, -0.01194852579, -0.03149889699, 0.9993758684,
                       0.01599041071, 0.01244783111, -0.01560487117, 0.9998007499};
  const double t[3] = {-0.4283604324, -4.741177559, -0.2027004212};
  double c[3];
  for (int i = 0; i < 3; ++i) c[i] = r[3 * i] * x[0] + r[3 * i + 1] * x[1] + r[3 * i + 2] * x[2] + t[i];
  const double focal = 0.9473756552, a = c[0] / c[2], b = c[1] / c[2], r2 = a * a + b * b;
  const double radial = 1 + k2 * r2 + k4 * r2 * r2;
  const double tall = w * aspect < h ? 1 : 0;  // a pixel is `aspect` as wide as it is high
  const double ax = tall ? focal * h / aspect : focal * w, ay = tall ? focal * h : focal * w * aspect;
  return {ax * a * radial + w * 0.49, ay * b * radial + h * 0.52};
}

TEST(Mve, ProjectsAsItsCookbookDoes) {
  struct Kind {
    double aspect;
    int w, h;
    double k2, k4;
  };
  for (const Kind& kind : {Kind{1, 640, 480, 0, 0}, Kind{1, 480, 640, 0, 0}, Kind{1.25, 640, 480, 0, 0},
                           Kind{0.5, 640, 480, 0, 0}, Kind{1, 640, 480, -0.11, 0.035}}) {
    const bool bent = kind.k2 != 0;
    std::string meta = replaced(kMeta, "pixel_aspect = 1", text("pixel_aspect = ", kind.aspect));
    if (bent)
      meta =
          replaced(meta, "rotation =", text("radial_distortion = ", kind.k2, " ", kind.k4, "\nrotation ="));
    MveView one = view("view_0000.mve", meta, kind.w, kind.h);
    one.straight = !bent;
    const Result<ForeignRig> rig = parse_mve({one}, "scene/views");
    ASSERT_THAT(rig, IsOk());
    const RigCamera& c = rig->rig.cameras[0];
    EXPECT_EQ(c.serial, "IMG_0191");
    EXPECT_EQ(rig->image_names[0], "view_0000.mve/undistorted.png");
    for (const Eigen::Vector3d& x :
         {Eigen::Vector3d(0.5, 4.6, 4), Eigen::Vector3d(1, 6, 5), Eigen::Vector3d(-0.7, 4, 3)})
      EXPECT_LT((*project(c.model, c.cam_from_world * x) -
                 by_the_cookbook(x, kind.aspect, kind.w, kind.h, kind.k2, kind.k4))
                    .norm(),
                1e-3)
          << kind.aspect << " " << kind.w << " " << kind.k2;
  }
}

TEST(Mve, CountsPixelsFromTheCorner) {
  const Result<ForeignRig> rig = parse_mve(
      {view("view_0000.mve", replaced(kMeta, "principal_point = 0.49 0.52\n", ""), 2, 2)}, "scene/views");
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[0].model.cx, 1);
  EXPECT_EQ(rig->rig.cameras[0].model.cy, 1);
}

TEST(Mve, LeavesOutViewsThatWereNotPlacedOrHaveNoPicture) {
  MveView unseen = view("view_0003.mve", replaced(kMeta, "IMG_0191", "c"));
  unseen.picture.clear();
  const Result<ForeignRig> rig =
      parse_mve({view("view_0000.mve", kMeta),
                 view("view_0001.mve", replaced(kMeta, "focal_length = 0.9473756552", "focal_length = 0")),
                 view("view_0002.mve", "[view]\nid = 2\nname = b\n"), unseen},
                "scene/views");
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras.size(), 1u);
  expect_error(mve("[view]\nid = 2\nname = b\n"), ErrorCode::BadData, {"none of its 1 views", "sfmrecon"});
}

TEST(Mve, NamesCamerasAfterTheirFoldersWhereViewsShareAName) {
  const Result<ForeignRig> rig =
      parse_mve({view("view_0000.mve", kMeta), view("view_0001.mve", kMeta)}, "scene/views");
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[0].serial, "view_0000");
  EXPECT_EQ(rig->rig.cameras[1].serial, "view_0001");
}

TEST(Mve, SaysWhatIsWrong) {
  const auto changed = [](std::string_view from, std::string_view to) {
    return mve(replaced(kMeta, from, to));
  };
  const std::string file = "scene/views/view_0000.mve/meta.ini";
  expect_error(changed("rotation = 0.99", "rotation = 9.99"), ErrorCode::BadData, {file, "rotation"});
  expect_error(changed("rotation = 0.9994262709 ", "rotation = "), ErrorCode::BadData,
               {file, "rotation", "9 numbers", "8"});
  expect_error(changed("focal_length = 0.9473756552", "focal_length = -1"), ErrorCode::BadData,
               {file, "focal_length"});
  expect_error(changed("pixel_aspect = 1", "pixel_aspect = 0"), ErrorCode::BadData, {file, "pixel_aspect"});
  expect_error(changed("translation = -0.4", "translation = nan"), ErrorCode::BadData, {file, "translation"});
  expect_error(changed("id = 0", "id : 0"), ErrorCode::BadData, {file, "line 12"});
  MveView original = view("view_0000.mve", kMeta);
  original.picture = "original.jpg";
  original.straight = false;
  expect_error(parse_mve({original}, "scene/views"), ErrorCode::BadData,
               {file, "original.jpg", "radial_distortion"});
}

TEST(Mve, RefusesEveryTruncation) { expect_truncations_refused(kMeta, 1, mve); }

class AnMveScene : public testing::Test {
 protected:
  AnMveScene() {
    for (const char* name : {"view_0000.mve", "view_0001.mve"}) {
      const std::filesystem::path folder = folder_ / "views" / name;
      std::filesystem::create_directories(folder);
      EXPECT_THAT(write_file(folder / "meta.ini", kMeta), IsOk());
      EXPECT_THAT(save_png(Image(32, 24, 3), folder / "undistorted.png"), IsOk());
      EXPECT_THAT(save_png(Image(64, 48, 3), folder / "original.png"), IsOk());
    }
  }
  const TempFolder folder_;
  const std::filesystem::path second_ = folder_ / "views/view_0001.mve";
};

TEST_F(AnMveScene, IsReadByItsFolderOrItsViews) {
  EXPECT_TRUE(is_mve(folder_.path()));
  for (const std::filesystem::path& path : {folder_.path(), folder_ / "views"}) {
    const Result<ForeignRig> rig = read_rig({.path = path});
    ASSERT_THAT(rig, IsOk());
    EXPECT_EQ(rig->rig.cameras.size(), 2u);
    EXPECT_EQ(rig->rig.cameras[0].model.width, 32) << "the undistorted picture is taken";
    EXPECT_EQ(rig->pictures, folder_ / "views");
    EXPECT_TRUE(rig->one_picture_each);
  }
}

TEST_F(AnMveScene, TakesTheOriginalWhereThereIsNothingStraight) {
  std::filesystem::remove(second_ / "undistorted.png");
  expect_error(read_mve(folder_.path()), ErrorCode::BadData, {"view_0001.mve/meta.ini", "original.png"});
  ASSERT_THAT(write_file(second_ / "meta.ini",
                         replaced(kMeta, "rotation =", "radial_distortion = -0.1 0\nrotation =")),
              IsOk());
  const Result<ForeignRig> rig = read_mve(folder_.path());
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[1].model.width, 64);
  EXPECT_EQ(rig->rig.cameras[1].model.lens, Lens(BrownConrady{.k1 = -0.1}));
}

TEST_F(AnMveScene, OfTheFirstFormatOrOfDeepPicturesIsRefused) {
  for (const char* name : {"undistorted.png", "original.png"}) std::filesystem::remove(second_ / name);
  ASSERT_THAT(write_file(second_ / "original.mvei", "\x89MVE_IMAGE\n"), IsOk());
  expect_error(read_mve(folder_.path()), ErrorCode::Unsupported, {"original.mvei", "PNG"});
  std::filesystem::remove_all(second_);
  ASSERT_THAT(write_file(second_, "\x89MVE\nid 1\n"), IsOk());
  expect_error(read_mve(folder_.path()), ErrorCode::Unsupported, {"view_0001.mve", "sceneupgrade"});
  std::filesystem::remove_all(folder_ / "views");
  expect_error(read_mve(folder_.path()), ErrorCode::NotFound, {"views/*.mve"});
}

}  // namespace
}  // namespace floatstage::calib
