#include "tests/pipeline/import/foreign_sets.h"

#include <iomanip>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core/persistence.hpp>

#include "core/file.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

constexpr int kWidth = 64, kHeight = 48;

// ---- two cameras: pixels count from the first one's centre ----

struct Seen {
  double fx, fy, cx, cy;       // px
  std::array<double, 5> lens;  // k1 k2 p1 p2 k3
  Matrix3d r;
  Vector3d t;  // metres; x = R X + t
};

const Seen& camera(int i) {
  static const std::array<Seen, 2> kCameras = {
      Seen{70, 71, 31.25, 23.5, {-0.1, 0.02, 0.001, -0.002, 0.003}, Matrix3d::Identity(), Vector3d::Zero()},
      Seen{75,
           74,
           32,
           24.25,
           {0.05, -0.01, -0.0005, 0.001, 0.002},
           (Eigen::AngleAxisd(0.3, Vector3d::UnitY()) * Eigen::AngleAxisd(-0.1, Vector3d::UnitX()))
               .toRotationMatrix(),
           Vector3d(-0.7, 0.1, 0.25)}};
  return kCameras[static_cast<std::size_t>(i)];
}

std::array<double, 5> terms(const Seen& c, LensTerms lens) {
  std::array<double, 5> d = c.lens;
  if (lens == LensTerms::None) return {};
  if (lens != LensTerms::Five) d[4] = 0;
  if (lens == LensTerms::Radial2) d[2] = d[3] = 0;
  return d;
}

}  // namespace

Vector2d by_opencv(int i, const Vector3d& point, LensTerms lens) {
  const Seen& c = camera(i);
  const Vector3d p = c.r * point + c.t;
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const auto [k1, k2, p1, p2, k3] = terms(c, lens);
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {c.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + c.cx + 0.5,
          c.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + c.cy + 0.5};
}

void put(const fs::path& file, const std::string& content) {
  fs::create_directories(file.parent_path());
  ASSERT_THAT(write_file(file, content), IsOk());
}

namespace {

// ---- the words of the formats ----

template <class... Numbers>
std::string row(const char* between, const Numbers&... numbers) {
  std::string out;
  ((out += text(out.empty() ? "" : between, std::setprecision(17), numbers)), ...);
  return out;
}
std::string matrix_rows(const Matrix3d& m, const char* between, const char* row_begin = "",
                        const char* row_end = "", const char* between_rows = " ") {
  std::string out;
  for (int i = 0; i < 3; ++i)
    out += text(i ? between_rows : "", row_begin, row(between, m(i, 0), m(i, 1), m(i, 2)), row_end);
  return out;
}
Matrix3d k_of(const Seen& c) {
  Matrix3d k;
  k << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
  return k;
}
std::string list(const Matrix3d& m) { return "[" + matrix_rows(m, ", ", "[", "]", ", ") + "]"; }
std::string list(const Vector3d& v) { return "[" + row(", ", v.x(), v.y(), v.z()) + "]"; }

void put_picture(const fs::path& file) {
  fs::create_directories(file.parent_path());
  Image picture(kWidth, kHeight, 3);
  for (std::size_t p = 0; p < picture.pixels.size(); ++p)
    picture.pixels[p] = static_cast<std::uint8_t>(p * 7);
  ASSERT_THAT(save_png(picture, file), IsOk());
}
void run(const std::string& command) {
  const Ended ended = run_command(command);
  ASSERT_EQ(ended.code, 0) << command << "\n" << ended.output;
}

std::string colmap_cameras(const char* model) {
  std::string out;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    out +=
        text(i + 1, " ", model, " ", kWidth, " ", kHeight, " ",
             row(" ", c.fx, c.fy, c.cx + 0.5, c.cy + 0.5, c.lens[0], c.lens[1], c.lens[2], c.lens[3]), "\n");
  }
  return out;
}

// A model in text that COLMAP's own converter writes as binary.
void write_colmap(const fs::path& folder) {
  put(folder / "text/cameras.txt", colmap_cameras("OPENCV"));
  std::string images;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Quaterniond q(camera(i).r);
    const Vector3d& t = camera(i).t;
    images += text(i + 1, " ", row(" ", q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()), " ", i + 1, " ",
                   i == 0 ? "a" : "b", ".png\n\n");
  }
  put(folder / "text/images.txt", images);
  put(folder / "text/points3D.txt", "");
  const fs::path model = folder / "sparse/0";
  fs::create_directories(model);
  run(text("colmap model_converter --input_path '", (folder / "text").string(), "' --output_path '",
           model.string(), "' --output_type BIN"));
  for (const char* name : {"a", "b"}) put_picture(folder / "images" / (std::string(name) + ".png"));
}

// The same model as text, whose cameras are others.
std::function<void(const fs::path&)> colmap_text(
    const std::vector<std::pair<std::string, std::string>>& changes) {
  return [=](const fs::path& folder) {
    for (const char* name : {"cameras", "images"})
      fs::remove(folder / "sparse/0" / (std::string(name) + ".bin"));
    fs::copy_file(folder / "text/images.txt", folder / "sparse/0/images.txt");
    std::string cameras = colmap_cameras("OPENCV");
    for (const auto& [from, to] : changes)
      for (std::size_t at = 0; (at = cameras.find(from, at)) != std::string::npos; at += to.size())
        cameras.replace(at, from.size(), to);
    put(folder / "sparse/0/cameras.txt", cameras);
  };
}

void write_opencv(const fs::path& folder) {
  fs::create_directories(folder);
  cv::FileStorage intri((folder / "intri.yml").string(), cv::FileStorage::WRITE),
      extri((folder / "extri.yml").string(), cv::FileStorage::WRITE);
  for (cv::FileStorage* file : {&intri, &extri})
    *file << "names"
          << "["
          << "a"
          << "b"
          << "]";
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    const std::string name = i == 0 ? "a" : "b";
    cv::Mat rotation(3, 3, CV_64F), k(3, 3, CV_64F);
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 3; ++x) rotation.at<double>(y, x) = c.r(y, x), k.at<double>(y, x) = k_of(c)(y, x);
    intri << "K_" + name << k;
    intri << "dist_" + name
          << cv::Mat(cv::Matx<double, 1, 5>(c.lens[0], c.lens[1], c.lens[2], c.lens[3], c.lens[4]));
    extri << "Rot_" + name << rotation;
    extri << "T_" + name << cv::Mat(cv::Matx<double, 3, 1>(c.t.x(), c.t.y(), c.t.z()));
    put_picture(folder / "images" / (name + ".png"));
  }
}

void write_pictures(const fs::path& folder, const Words& pictures) {
  for (const std::string& picture : pictures) put_picture(folder / picture);
}

std::string qualisys_camera(int i) {
  const Seen& c = camera(i);
  const Matrix3d axes =
      Eigen::DiagonalMatrix<double, 3>(1, -1, -1) * c.r;  // x right, y up, z backwards, by rows
  const Vector3d place = -1000 * (c.r.transpose() * c.t);
  const auto number = [](const char* name, double value) {
    return text(" ", name, "=\"", std::setprecision(17), value, "\"");
  };
  std::string out =
      text("  <camera active=\"1\" serial=\"", i == 0 ? "a" : "b",
           "\">\n   <fov_video left=\"0\" top=\"0\" right=\"", kWidth - 1, "\" bottom=\"", kHeight - 1,
           "\"/>\n   <transform", number("x", place.x()), number("y", place.y()), number("z", place.z()));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) out += number(text("r", y + 1, x + 1).c_str(), axes(y, x));
  return out + "/>\n   <intrinsic" + number("focalLengthU", 64 * c.fx) + number("focalLengthV", 64 * c.fy) +
         number("centerPointU", 64 * c.cx) + number("centerPointV", 64 * c.cy) + " skew=\"0\"" +
         number("radialDistortion1", c.lens[0]) + number("radialDistortion2", c.lens[1]) +
         number("radialDistortion3", c.lens[4]) + number("tangentalDistortion1", c.lens[2]) +
         number("tangentalDistortion2", c.lens[3]) + "/>\n  </camera>\n";
}

std::string transforms() {
  std::string frames;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    const Matrix3d axes =
        c.r.transpose() * Eigen::DiagonalMatrix<double, 3>(1, -1, -1);  // x right, y up, z backwards
    const Vector3d place = -(c.r.transpose() * c.t);
    frames +=
        text(i ? ",\n" : "", R"({"file_path": "images/)", i == 0 ? "a" : "b", R"(.png", "w": 64, "h": 48, )",
             std::setprecision(17), "\"fl_x\": ", c.fx, ", \"fl_y\": ", c.fy, ", \"cx\": ", c.cx + 0.5,
             ", \"cy\": ", c.cy + 0.5, ", \"k1\": ", c.lens[0], ", \"k2\": ", c.lens[1],
             ", \"p1\": ", c.lens[2], ", \"p2\": ", c.lens[3], ", \"transform_matrix\": [");
    for (int y = 0; y < 3; ++y)
      frames += "[" + row(", ", axes(y, 0), axes(y, 1), axes(y, 2), place(y)) + "], ";
    frames += "[0, 0, 0, 1]]}";
  }
  return "{\"camera_model\": \"OPENCV\", \"frames\": [" + frames + "]}";
}

std::string openmvg() {
  std::string views, intrinsics, poses;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    const std::string comma = i ? ",\n" : "", key = text("{\"key\": ", i, ", \"value\": ");
    views += comma + key +
             text(R"({"polymorphic_id": 1073741824, "ptr_wrapper": {"id": )", 2147483649 + i,
                  R"(, "data": {"local_path": "/", "filename": ")", i == 0 ? "a" : "b",
                  R"(.png", "width": 64, "height": 48, "id_view": )", i, ", \"id_intrinsic\": ", i,
                  ", \"id_pose\": ", i, "}}}}");
    // One focal length: OpenMVG's pixels are square, so its set has them so.
    intrinsics +=
        comma + key +
        text(
            R"({"polymorphic_id": 2147483649, "polymorphic_name": "pinhole_brown_t2", "ptr_wrapper": {"id": )",
            2147483659 + i, R"(, "data": {"width": 64, "height": 48, "focal_length": )",
            std::setprecision(17), c.fx, ", \"principal_point\": [", row(", ", c.cx, c.cy),
            "], \"disto_t2\": [", row(", ", c.lens[0], c.lens[1], c.lens[4], c.lens[2], c.lens[3]), "]}}}}");
    const Vector3d place = -(c.r.transpose() * c.t);
    poses += comma + key + "{\"rotation\": " + list(c.r) + ", \"center\": " + list(place) + "}}";
  }
  return "{\"sfm_data_version\": \"0.3\", \"root_path\": \"\",\n\"views\": [" + views +
         "],\n\"intrinsics\": [" + intrinsics + "],\n\"extrinsics\": [" + poses +
         "], \"structure\": [], \"control_points\": []}";
}

// fy of formats that have one focal length.
Vector2d square(int i, const Vector3d& point, LensTerms lens) {
  const Seen& c = camera(i);
  Vector2d seen = by_opencv(i, point, lens);
  seen.y() = (seen.y() - 0.5 - c.cy) * c.fx / c.fy + c.cy + 0.5;
  return seen;
}

std::string mve_meta(int i) {
  const Seen& c = camera(i);
  return text("# MVE view meta data is stored in INI-file syntax.\n\n[camera]\nfocal_length = ",
              std::setprecision(10), c.fx / kWidth, "\npixel_aspect = ", c.fy / c.fx,
              "\nprincipal_point = ", (c.cx + 0.5) / kWidth, " ", (c.cy + 0.5) / kHeight,
              "\nrotation = ", matrix_rows(c.r, " "), "\ntranslation = ", row(" ", c.t.x(), c.t.y(), c.t.z()),
              "\n\n[view]\nid = ", i, "\nname = ", i == 0 ? "a" : "b", "\n");
}

std::string panoptic() {
  std::string cameras;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    const Vector3d t = 100 * c.t;  // centimetres
    cameras += text(
        i ? ",\n" : "", R"({"name": "00_0)", i,
        R"(", "type": "hd", "resolution": [64, 48], "panel": 0, "node": )", i, ", \"K\": ", list(k_of(c)),
        ", \"distCoef\": [", row(", ", c.lens[0], c.lens[1], c.lens[2], c.lens[3], c.lens[4]),
        "], \"R\": ", list(c.r), ", \"t\": [",
        row(", ", text("[", std::setprecision(17), t.x(), "]"), text("[", std::setprecision(17), t.y(), "]"),
            text("[", std::setprecision(17), t.z(), "]")),
        "]}");
  }
  return R"({"calibDataSource": "160422_calib_norm", "cameras": [)" + cameras + "]}";
}

std::string dome() {
  std::string out;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    out +=
        text(i, "\n", matrix_rows(k_of(c), "\t", "", "", "\n"), "\n", row("\t", c.lens[0], c.lens[1]), "\n");
    for (int y = 0; y < 3; ++y) out += row("\t", c.r(y, 0), c.r(y, 1), c.r(y, 2), 10 * c.t(y)) + "\n";
    out += "\n";
  }
  return out;
}

std::string kalibr() {
  std::string out;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    out += text("cam", i, ":\n");
    if (i == 1) {
      out += "  T_cn_cnm1:\n";
      for (int y = 0; y < 3; ++y) out += "  - [" + row(", ", c.r(y, 0), c.r(y, 1), c.r(y, 2), c.t(y)) + "]\n";
      out += "  - [0.0, 0.0, 0.0, 1.0]\n";
    }
    out += text("  cam_overlaps: [", 1 - i, "]\n  camera_model: pinhole\n  distortion_coeffs: [",
                row(", ", c.lens[0], c.lens[1], c.lens[2], c.lens[3]),
                "]\n  distortion_model: radtan\n  intrinsics: [", row(", ", c.fx, c.fy, c.cx, c.cy),
                "]\n  resolution: [64, 48]\n  rostopic: /", i == 0 ? "a" : "b", "/image_raw\n");
  }
  return out;
}

}  // namespace

std::string middlebury() {
  std::string out = "2\n";
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    out += text(i == 0 ? "a" : "b", ".png ", matrix_rows(k_of(c), " "), " ", matrix_rows(c.r, " "), " ",
                row(" ", c.t.x(), c.t.y(), c.t.z()), "\n");
  }
  return out;
}

namespace {

// docs/formats.md's own.
void write_own(const fs::path& folder) {
  Rig rig;
  for (int i = 0; i < 2; ++i) {
    const Seen& c = camera(i);
    CameraModel m{.width = kWidth,
                  .height = kHeight,
                  .fx = c.fx,
                  .fy = c.fy,
                  .cx = c.cx + 0.5,
                  .cy = c.cy + 0.5,
                  .lens = {}};
    m.lens = BrownConrady{c.lens[0], c.lens[1], c.lens[2], c.lens[3], c.lens[4]};
    rig.cameras.push_back({i == 0 ? "a" : "b", m, {Eigen::Quaterniond(c.r), c.t}, {}});
  }
  fs::create_directories(folder);
  ASSERT_THAT(save_rig(rig, folder / "rig.json"), IsOk());
  write_pictures(folder, {"a.png", "b.png"});
}

// Cameras 0 and 92.5 mm to the right, 0 and 40 mm down, a lens of 30 mm before 36 mm.
const Words kGrid = {"shop_00_00_0.0_0.0_30_36.png", "shop_00_01_0.0_92.5_30_36.png",
                     "shop_01_00_40_0.0_30_36.png", "shop_01_01_40_92.5_30_36.png"};
Vector2d by_lightfield(int i, const Vector3d& p) {
  const double f = 30.0 / 36 * kWidth, x = i == 0 ? 0 : 0.0925, down = i == 0 ? 0 : 0.04;
  return {f * (p.x() - x) / p.y() + kWidth / 2.0, f * (-p.z() - down) / p.y() + kHeight / 2.0};
}

std::function<void(const fs::path&)> one_file(const char* name, std::string (*content)(),
                                              const Words& pictures) {
  return [=](const fs::path& folder) {
    put(folder / name, content());
    write_pictures(folder, pictures);
  };
}

const Words kBoth = {"a.png", "b.png"};

}  // namespace

const std::vector<Format>& foreign_sets() {
  static const std::vector<Format> kFormats = {
      {"rig",
       "its documentation",
       write_own,
       LensTerms::Five,
       {"rig.json"},
       kBoth,
       Change{"rig.json", "\"floatstage_rig\": ", "\"floatstage_rig\": 9", kUnsupported, "reads formats"},
       Change{"rig.json", "brown", "oval", kBadData, "oval"},
       Change{"rig.json", "\"fx\": 70", "\"fx\": 0", kBadData}},
      {"middlebury",
       "its documentation",
       one_file("x_par.txt", middlebury, kBoth),
       LensTerms::None,
       {"x_par.txt"},
       kBoth,
       {},
       {},
       Change{"x_par.txt", "a.png 70 ", "a.png 0 "}},
      {"colmap",
       "COLMAP (`model_converter`)",
       write_colmap,
       LensTerms::Radial2Tangential,
       {"sparse/0/cameras.bin", "sparse/0/images.bin"},
       {"images/a.png", "images/b.png"},
       {},
       Change{"sparse/0/cameras.txt", "", "", kUnsupported, "THIN_PRISM_FISHEYE",
              colmap_text({{"OPENCV", "THIN_PRISM_FISHEYE"}, {"\n", " 0 0 0 0\n"}})},
       Change{"sparse/0/cameras.txt", "", "", kBadData, "", colmap_text({{" 70 ", " 0 "}})}},
      {"opencv",
       "OpenCV (`FileStorage`)",
       write_opencv,
       LensTerms::Five,
       {"intri.yml", "extri.yml"},
       {"images/a.png", "images/b.png"},
       {},
       Change{"intri.yml", "", "", kUnsupported, "dist_a",
              [](const fs::path& f) {
                std::string intri = *read_file(f / "intri.yml");
                const std::size_t cols = intri.find("cols: 5"), end = intri.find(']', cols);
                intri.insert(end, ", 0., 0., 0., 0., 0., 0., 0., 0., 0.25 ").replace(cols, 7, "cols: 14");
                put(f / "intri.yml", intri);
              }},
       Change{"intri.yml", "70., 0., ", "0., 0., "}},
      {"kalibr",
       "its documentation",
       one_file("x-camchain.yaml", kalibr, kBoth),
       LensTerms::Radial2Tangential,
       {"x-camchain.yaml"},
       kBoth,
       {},
       Change{"x-camchain.yaml", "camera_model: pinhole", "camera_model: omni", kUnsupported, "omni"},
       Change{"x-camchain.yaml", "intrinsics: [70,", "intrinsics: [0,"}},
      {"qualisys",
       "its documentation",
       [](const fs::path& f) {
         put(f / "x.qca.txt", "<?xml version=\"1.0\"?>\n<calibration>\n <cameras>\n" + qualisys_camera(0) +
                                  qualisys_camera(1) + " </cameras>\n</calibration>\n");
         write_pictures(f, kBoth);
       },
       LensTerms::Five,
       {"x.qca.txt"},
       kBoth,
       {},
       {},
       Change{"x.qca.txt", "focalLengthU=\"4480\"", "focalLengthU=\"0\""}},
      {"transforms",
       "its documentation",
       one_file("transforms.json", transforms, {"images/a.png", "images/b.png"}),
       LensTerms::Radial2Tangential,
       {"transforms.json"},
       {"images/a.png", "images/b.png"},
       {},
       Change{"transforms.json", "\"OPENCV\"", "\"EQUIRECTANGULAR\"", kUnsupported, "EQUIRECTANGULAR"},
       Change{"transforms.json", "\"fl_x\": 70, \"fl_y\": 71", "\"fl_x\": 0, \"fl_y\": 0"}},
      {"openmvg",
       "its documentation",
       one_file("sfm_data.json", openmvg, kBoth),
       LensTerms::Five,
       {"sfm_data.json"},
       kBoth,
       Change{"sfm_data.json", "\"0.3\"", "\"9.0\"", kUnsupported, "9.0"},
       Change{"sfm_data.json", "pinhole_brown_t2", "spherical", kUnsupported, "spherical"},
       Change{"sfm_data.json", "\"focal_length\": 70", "\"focal_length\": 0"},
       {},
       [](int i, const Vector3d& p) { return square(i, p, LensTerms::Five); }},
      {"mve",
       "its documentation",
       [](const fs::path& f) {
         for (int i = 0; i < 2; ++i) {
           put(f / text("views/view_000", i, ".mve/meta.ini"), mve_meta(i));
           for (const char* use : {"undistorted", "thumbnail"})
             put_picture(f / text("views/view_000", i, ".mve/", use, ".png"));
         }
       },
       LensTerms::None,
       {"views/view_0001.mve/meta.ini"},
       {"views/view_0000.mve/undistorted.png", "views/view_0001.mve/undistorted.png"},
       Change{"views/view_0002.mve", "", "", kUnsupported, "sceneupgrade",
              [](const fs::path& f) { put(f / "views/view_0002.mve", "\x89MVE\nid 2\n"); }},
       {},
       Change{"views/view_0001.mve/meta.ini", "pixel_aspect = ", "pixel_aspect = -"},
       {},
       {},
       kBadData},
      {"panoptic",
       "its documentation",
       one_file("calibration_x.json", panoptic, {"00_00.png", "00_01.png"}),
       LensTerms::Five,
       {"calibration_x.json"},
       {"00_00.png", "00_01.png"},
       {},
       {},
       Change{"calibration_x.json", "[[70, ", "[[0, "}},
      {"dome",
       "its documentation",
       one_file("calibration.txt", dome, {"images/00.png", "images/01.png"}),
       LensTerms::Radial2,
       {"calibration.txt"},
       {"images/00.png", "images/01.png"},
       {},
       {},
       Change{"calibration.txt", "70\t0\t", "0\t0\t"}},
      {"lightfield",
       "its documentation",
       [](const fs::path& f) { write_pictures(f, kGrid); },
       LensTerms::None,
       {kGrid[0]},
       kGrid,
       {},
       {},
       Change{"shop_01_01_40_92.5_30_0.png", "", "", kBadData, "",
              [](const fs::path& f) { fs::rename(f / kGrid[3], f / "shop_01_01_40_92.5_30_0.png"); }},
       {"--plane", "2"},
       by_lightfield},
  };
  return kFormats;
}

}  // namespace floatstage
