#include <cstring>

#include "calib/colmap_model.h"
#include "calib/formats/colmap_cameras.h"
#include "calib/formats/parsers.h"
#include "core/file.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string one_camera(std::int32_t model, const std::vector<double>& parameters, std::uint64_t width = 640) {
  std::string out;
  put<std::uint64_t>(out, 1);
  put<std::uint32_t>(out, 7);
  put(out, model);
  put(out, width);
  put<std::uint64_t>(out, 480);
  for (const double p : parameters) put(out, p);
  return out;
}

// One image with `points` observations.
std::string one_image(std::uint32_t camera = 7, double w = 1, std::uint64_t points = 2) {
  std::string out;
  put<std::uint64_t>(out, 1);
  put<std::uint32_t>(out, 3);
  for (const double v : {w, 0.0, 0.0, 0.0, 0.5, -0.5, 2.0}) put(out, v);
  put(out, camera);
  out.append("left.png", 9);
  put(out, points);
  out.append(points < 9 ? points * 24 : 0, 'x');
  return out;
}

const std::vector<double> kPinhole{500, 510, 320, 240};

Result<ForeignRig> from_binary(const std::string& cameras, const std::string& images) {
  return parse_colmap_binary(cameras, images, "cameras.bin", "images.bin");
}

TEST(ColmapBinary, SaysWhatTheTextSays) {
  for (const Lens& lens : {Lens{}, Lens(BrownConrady{0.1, -0.2, 0.003, 0.004}),
                           Lens(BrownConrady{0.1, 0, 0, 0, 0.2}), Lens(KannalaBrandt{0.1, 0.2, 0.3, 0.4})}) {
    TempFolder folder;
    const Rig rig = sample_rig(lens);
    const std::vector<ColmapPoint> points{{{1, 2, 3}, {4, 5, 6}}};
    ASSERT_THAT(write_colmap_model(rig, {"cam0", "cam1", "cam2"}, points, folder / "m"), IsOk());
    const auto bytes = [&](const char* name) { return read_file(folder / "m" / name).value(); };
    const Result<ForeignRig> binary = from_binary(bytes("cameras.bin"), bytes("images.bin"));
    const Result<ForeignRig> words = parse_colmap(bytes("cameras.txt"), bytes("images.txt"), "c", "i");
    ASSERT_THAT(binary, IsOk());
    ASSERT_THAT(words, IsOk());
    expect_same(words->rig, binary->rig, 1e-15);
    expect_same(rig, binary->rig, 1e-12);
    EXPECT_EQ(binary->image_names, words->image_names);
  }
}

TEST(ColmapBinary, ReadsEveryModelThatOurLensesHold) {
  const auto lens = [](std::int32_t model, const std::vector<double>& parameters) {
    const Result<ForeignRig> rig = from_binary(one_camera(model, parameters), one_image());
    EXPECT_THAT(rig, IsOk());
    return rig ? rig->rig.cameras[0].model.lens : Lens{};
  };
  EXPECT_EQ(lens(0, {500, 320, 240}), Lens{});
  EXPECT_EQ(lens(1, kPinhole), Lens{});
  EXPECT_EQ(lens(2, {500, 320, 240, 0.1}), Lens(BrownConrady{.k1 = 0.1}));
  EXPECT_EQ(lens(3, {500, 320, 240, 0.1, 0.2}), Lens(BrownConrady{.k1 = 0.1, .k2 = 0.2}));
  EXPECT_EQ(lens(4, {500, 510, 320, 240, 1, 2, 3, 4}), Lens(BrownConrady{1, 2, 3, 4}));
  EXPECT_EQ(lens(5, {500, 510, 320, 240, 1, 2, 3, 4}), Lens(KannalaBrandt{1, 2, 3, 4}));
  EXPECT_EQ(lens(6, {500, 510, 320, 240, 1, 2, 3, 4, 5, 0, 0, 0}), Lens(BrownConrady{1, 2, 3, 4, 5}));
  EXPECT_EQ(lens(8, {500, 320, 240, 0.1}), Lens(KannalaBrandt{.k1 = 0.1}));
  EXPECT_EQ(lens(9, {500, 320, 240, 0.1, 0.2}), Lens(KannalaBrandt{.k1 = 0.1, .k2 = 0.2}));
}

TEST(ColmapBinary, SaysWhatIsWrong) {
  const std::string camera = one_camera(1, kPinhole);
  expect_error(from_binary(one_camera(7, {500, 510, 320, 240, 1}), one_image()), ErrorCode::Unsupported,
               {"cameras.bin", "camera 7", "FOV"});
  expect_error(from_binary(one_camera(99, kPinhole), one_image()), ErrorCode::Unsupported, {"number 99"});
  expect_error(from_binary(one_camera(1, {500, std::nan(""), 320, 240}), one_image()), ErrorCode::BadData,
               {"camera 7", "finite"});
  expect_error(from_binary(one_camera(1, kPinhole, std::uint64_t{1} << 40U), one_image()), ErrorCode::BadData,
               {"camera 7", "size"});
  expect_error(from_binary(camera + "x", one_image()), ErrorCode::BadData, {"cameras.bin", "1 bytes follow"});
  expect_error(from_binary(camera, one_image(8)), ErrorCode::BadData,
               {"left.png", "camera 8", "cameras.bin"});
  expect_error(from_binary(camera, one_image(7, 1.1)), ErrorCode::BadData, {"left.png", "length"});
  expect_error(from_binary(camera, one_image(7, 1, std::uint64_t{1} << 62U)), ErrorCode::BadData,
               {"images.bin", "cut off"});
}

TEST(ColmapBinary, RefusesEveryTruncation) {
  const std::string camera = one_camera(1, kPinhole), image = one_image();
  for (std::size_t length = 0; length < camera.size(); ++length)
    expect_error(from_binary(camera.substr(0, length), image), ErrorCode::BadData, {"cameras.bin"});
  for (std::size_t length = 0; length < image.size(); ++length)
    expect_error(from_binary(camera, image.substr(0, length)), ErrorCode::BadData, {"images.bin"});
}

}  // namespace
}  // namespace floatstage::calib
