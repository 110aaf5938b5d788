// Camera paths in other programs' files, there and back, and read by those programs.
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "pipeline/export/export_path.h"
#include "pipeline/import/gltf_camera.h"
#include "pipeline/import/import_path.h"
#include "tests/pipeline/export/processed_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::json;
using testing::HasSubstr;

// Bullet time: on, around what stands still, with a zoom, and on.
CameraPath bullet_time() {
  PathKey key;
  key.eye = {3, 0, 1.5}, key.target = {0, 0, 1};
  CameraPath path{{key, key, key, key}};
  for (std::size_t i = 0; i < 4; ++i) path.keys[i].time = static_cast<double>(i);
  path.keys[0].take_time = 0, path.keys[1].take_time = path.keys[2].take_time = 1, path.keys[3].take_time = 2;
  path.keys[1].orbit = 1, path.keys[2].ease_out = 1;
  path.keys[2].fov_y = 25;
  path.keys[3].eye = {0, -4, 2};
  return path;
}

// The cameras of a path and of what was read back of it, at the same times.
void expect_same(const CameraPath& path, const CameraPath& again, bool with_take_times) {
  const std::vector<FilmCamera> wanted =
      film_cameras(path, 25, {}, with_take_times ? FilmTimes::WithEnd : FilmTimes::Pictures);
  ASSERT_EQ(again.keys.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const PathKey& key = again.keys[i];
    const Rigid3 here = look_at(key.eye, key.target, key.up);
    EXPECT_NEAR(key.time, wanted[i].time, 1e-6);
    EXPECT_LT((here.center() - wanted[i].cam_from_world.center()).norm(), 1e-6) << i;
    EXPECT_LT(here.rotation.angularDistance(wanted[i].cam_from_world.rotation), 1e-6) << i;
    EXPECT_NEAR(key.fov_y, wanted[i].fov_y, 1e-6) << i;
    if (with_take_times) {
      EXPECT_EQ(key.take_time, wanted[i].take_time) << i;
      EXPECT_LT((key.target - sample(path, wanted[i].time).target).norm(), 1e-6) << i;
    }
  }
}

class PathFiles : public testing::Test {
 protected:
  Result<void> write(const fs::path& out, bool z_up = false) const {
    return export_path(
        film_cameras(bullet_time(), 25, {}, names_a_gltf(out) ? FilmTimes::WithEnd : FilmTimes::Pictures),
        640, 360, z_up, out);
  }
  Result<CameraPath> parsed(const json& gltf, const std::string& camera = "") const {
    const Result<std::vector<FilmCamera>> cameras =
        parse_gltf_camera(gltf.dump(), "a.gltf", folder_.path(), false, camera);
    if (!cameras) return forward(cameras);
    return path_through(*cameras);
  }
  static json exported() {
    return json::parse(to_gltf(film_cameras(bullet_time(), 25, {}, FilmTimes::WithEnd), false, false));
  }

  TempFolder folder_;
};

TEST_F(PathFiles, GoToGltfAndBack) {
  for (const char* name : {"y.gltf", "y.glb", "z.glb"}) {
    const bool z_up = name[0] == 'z';
    ASSERT_THAT(write(folder_ / name, z_up), IsOk());
    const Result<CameraPath> again = import_path({.from = folder_ / name, .z_up = z_up});
    ASSERT_THAT(again, IsOk()) << name;
    expect_same(bullet_time(), *again, true);
    const fs::path log = folder_ / "assimp.log";
    EXPECT_EQ(run_other(text("assimp info ", (folder_ / name).string(), " -r"), log), 0) << *read_file(log);
    EXPECT_THAT(*read_file(log), HasSubstr("Cameras:            1"));
    EXPECT_THAT(*read_file(log), HasSubstr("Animations:         1"));
  }
  EXPECT_THAT(write(folder_ / "y.glb"), FailsWith(ErrorCode::AlreadyExists, "y.glb"));
}

TEST_F(PathFiles, GoToColmapAndBackInTextAndBinary) {
  const fs::path out = folder_ / "cameras", log = folder_ / "colmap.log";
  ASSERT_THAT(write(out), IsOk());
  const Result<CameraPath> binary = import_path({.from = out});
  ASSERT_THAT(binary, IsOk());
  expect_same(bullet_time(), *binary, false);
  ASSERT_EQ(run_other(text("colmap model_analyzer --path ", out.string()), log), 0) << *read_file(log);
  EXPECT_THAT(*read_file(log), HasSubstr("Images: 75"));
  fs::create_directory(folder_ / "text");
  ASSERT_EQ(run_other(text("colmap model_converter --input_path ", out.string(), " --output_path ",
                           (folder_ / "text").string(), " --output_type TXT"),
                      log),
            0);
  const Result<CameraPath> words = import_path({.from = folder_ / "text"});
  ASSERT_THAT(words, IsOk()) << "as COLMAP itself wrote it";
  expect_same(bullet_time(), *words, false);
}

// A boom that turns about the axis that is up, half a turn in two seconds, with a camera on its end.
TEST_F(PathFiles, OfOtherProgramsMoveByTheNodesAboveTheCameraToo) {
  json gltf = exported();
  gltf["animations"][0].erase("extras");
  gltf["nodes"] =
      json::array({json{{"name", "boom"}, {"children", json::array({1})}},
                   json{{"name", "camera"}, {"camera", 0}, {"translation", json::array({0, 1, 3})}}});
  const std::vector<float> numbers = {0, 2, /**/ 0, 0, 0, 1, 0, 1, 0, 0};
  std::ofstream(folder_ / "boom.bin", std::ios::binary)
      .write(reinterpret_cast<const char*>(numbers.data()), static_cast<std::streamsize>(numbers.size() * 4));
  gltf["buffers"] = json::array({json{{"uri", "boom.bin"}, {"byteLength", 40}}});
  gltf["bufferViews"] = json::array(
      {json{{"buffer", 0}, {"byteLength", 8}}, json{{"buffer", 0}, {"byteOffset", 8}, {"byteLength", 32}}});
  gltf["accessors"] =
      json::array({json{{"bufferView", 0}, {"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}},
                   json{{"bufferView", 1}, {"componentType", 5126}, {"count", 2}, {"type", "VEC4"}}});
  gltf["animations"][0]["samplers"] = json::array({json{{"input", 0}, {"output", 1}}});
  gltf["animations"][0]["channels"] =
      json::array({json{{"sampler", 0}, {"target", json{{"node", 0}, {"path", "rotation"}}}}});
  const Result<CameraPath> path = parsed(gltf);
  ASSERT_THAT(path, IsOk());
  EXPECT_EQ(path->keys.size(), 51u) << "as densely as films are";
  for (const PathKey& key : path->keys) {
    const double angle = M_PI / 2 * key.time;
    EXPECT_LT((key.eye - Vector3d(3 * std::sin(angle), -3 * std::cos(angle), 1)).norm(), 1e-6) << key.time;
    EXPECT_LT((key.target - Vector3d(0, 0, 1)).norm(), 1e-6) << "it looks along the boom, to the middle";
    EXPECT_LT((key.up - Vector3d::UnitZ()).norm(), 1e-6);
  }
  gltf["animations"][0]["samplers"][0]["interpolation"] = "STEP";
  EXPECT_LT((parsed(gltf)->keys[25].eye - Vector3d(0, -3, 1)).norm(), 1e-6);
  EXPECT_THAT(parsed(gltf, "crane"), FailsWith(ErrorCode::NotFound, "there are: camera"));
  EXPECT_THAT(parsed(gltf, "film"), IsOk());
}

TEST_F(PathFiles, AreRefusedBySentenceWhereTheyMakeNoSense) {
  const auto with = [](auto change) {
    json gltf = exported();
    change(gltf);
    return gltf;
  };
  const auto shorter = [](json& g) { g["buffers"][0]["uri"] = "data:application/octet-stream;base64,AAAA"; };
  EXPECT_THAT(parsed(with(shorter)), FailsWith(ErrorCode::BadData, "cut short"));
  EXPECT_THAT(parsed(with([](json& g) { g["nodes"][1].erase("camera"); })),
              FailsWith(ErrorCode::NotFound, "no camera"));
  EXPECT_THAT(parsed(with([](json& g) { g.erase("animations"); })),
              FailsWith(ErrorCode::InvalidArgument, "two times"));
  EXPECT_THAT(parsed(with([](json& g) { g["cameras"][0]["type"] = "orthographic"; })),
              FailsWith(ErrorCode::Unsupported, "perspective"));
  EXPECT_THAT(parsed(with([](json& g) {
                g["nodes"][0]["scale"] = json::array({1, 2, 1});
              })),
              FailsWith(ErrorCode::BadData, "sheared"));
  EXPECT_THAT(parsed(with([](json& g) { g["nodes"][1]["children"] = json::array({0}); })),
              FailsWith(ErrorCode::BadData, "below itself"));
  EXPECT_THAT(parsed(with([](json& g) { g["buffers"][0]["uri"] = "../../etc/passwd"; })),
              FailsWith(ErrorCode::BadData, "not a file beside it"));
  EXPECT_THAT(parsed(with([](json& g) { g["animations"][0]["samplers"][0]["input"] = "soon"; })),
              FailsWith(ErrorCode::BadData, "no glTF 2.0"));
  std::vector<FilmCamera> backwards = film_cameras(bullet_time(), 25, {}, FilmTimes::WithEnd);
  std::swap(backwards[3].time, backwards[4].time);
  EXPECT_THAT(parsed(json::parse(to_gltf(backwards, false, false))),
              FailsWith(ErrorCode::BadData, "do not grow"));
  backwards = film_cameras(bullet_time(), 25, {}, FilmTimes::WithEnd);
  backwards[5].cam_from_world.translation.x() = NAN;
  EXPECT_THAT(parsed(json::parse(to_gltf(backwards, false, false))), FailsWith(ErrorCode::BadData, "finite"));
}

TEST_F(PathFiles, AreRefusedWhereverTheyAreCutOff) {
  const std::string whole = to_gltf(film_cameras(bullet_time(), 25, {}, FilmTimes::WithEnd), false, true);
  for (std::size_t n = 0; n < whole.size(); n += 7)
    EXPECT_FALSE(parse_gltf_camera(std::string_view(whole).substr(0, n), "a.glb", folder_.path(), false, ""))
        << n;
}

TEST_F(PathFiles, LeaveNothingBehindOfOneKeyOrOneImage) {
  CameraPath still = bullet_time();
  still.keys.resize(1);
  const std::vector<FilmCamera> one = film_cameras(still, 25, {}, FilmTimes::WithEnd);
  EXPECT_THAT(export_path(one, 640, 360, false, folder_ / "one"),
              FailsWith(ErrorCode::InvalidArgument, "one key"));
  EXPECT_FALSE(fs::exists(folder_ / "one"));
  ASSERT_THAT(write(folder_ / "cameras"), IsOk());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"})
    fs::remove(folder_ / "cameras" / name);
  const fs::path images = folder_ / "cameras/images.txt";
  const std::string first = read_file(images)->substr(0, read_file(images)->find("\n2 ") + 1);
  ASSERT_THAT(write_file(images, first), IsOk());
  EXPECT_THAT(import_path({.from = folder_ / "cameras"}),
              FailsWith(ErrorCode::InvalidArgument, "one time only"));
  ASSERT_THAT(write_file(images, first.substr(0, first.size() / 2)), IsOk());
  EXPECT_THAT(import_path({.from = folder_ / "cameras"}), FailsWith(ErrorCode::BadData, "images.txt"));
}

}  // namespace
}  // namespace floatstage::pipeline
