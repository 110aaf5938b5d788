// apps/python/floatstage.py, a program of another language, reads the same as Floatstage does.
#include <fstream>
#include <iomanip>
#include <sstream>

#include <gmock/gmock.h>

#include "capture/added_file.h"
#include "capture/sha256.h"
#include "capture/take.h"
#include "core/color.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "core/random.h"
#include "core/rig_io.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "tests/capture/sound/sound_support.h"
#include "tests/support/places.h"
#include "tests/support/run_command.h"
#include "tests/support/small_take.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Debian's interpreter, for which its NumPy is.
std::string python_says(const std::string& what, const fs::path& path) {
  const Ended ended =
      run_command(text("/usr/bin/python3 '", (source_folder() / "tests/apps/read_a_take.py").string(), "' '",
                       (source_folder() / "apps/python").string(), "' ", what, " '", path.string(), "'"));
  EXPECT_EQ(ended.code, 0) << ended.output;
  return ended.output;
}

template <typename T>
std::string hash_of(const std::vector<T>& values) {
  return capture::sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

std::string digest_of(const Image& image) {
  return text(image.height, "x", image.width, image.channels == 1 ? "" : text("x", image.channels), " ",
              hash_of(image.pixels));
}

std::string digest_of(const Mesh& mesh) {
  std::vector<float> vertices;
  std::vector<std::int32_t> faces;
  for (const Eigen::Vector3f& v : mesh.positions) vertices.insert(vertices.end(), {v.x(), v.y(), v.z()});
  for (const std::uint32_t i : mesh.triangles) faces.push_back(static_cast<std::int32_t>(i));
  return text(vertices.size() / 3, "x3 ", hash_of(vertices), " ", faces.size() / 3, "x3 ", hash_of(faces));
}

class PythonReader : public testing::Test {
 protected:
  TempFolder folder_;
};

TEST_F(PythonReader, ReadsPhotographsMattesAndMeshesByteForByte) {
  pipeline::SynthesizeOptions options;
  options.out = folder_ / "take";
  options.rig.cameras = 3;
  options.rig.width = 160;
  options.rig.height = 120;
  options.studio.samples = 4;
  options.studio.defects.dropped_frames = 0.3;
  options.frames = 5;
  ASSERT_THAT(pipeline::synthesize_take(options), IsOk());
  const fs::path take = options.out;
  const Result<std::unique_ptr<capture::TakeReader>> reader = capture::TakeReader::open(take);
  ASSERT_THAT(reader, IsOk());
  fs::copy(take / "truth/mattes", take / "mattes", fs::copy_options::recursive);
  fs::copy(take / "truth/meshes", take / "meshes", fs::copy_options::recursive);

  const TakeLayout layout(take);
  std::ostringstream expected;
  expected << "take 3 5 1\n";
  int gaps = 0;
  for (int c = 0; c < 3; ++c) {
    const std::string serial = (*reader)->rig().cameras[c].serial;
    for (int k = 0; k < 5; ++k) {
      const Result<Frame> frame = (*reader)->frame(c, k);
      ASSERT_THAT(frame, IsOk());
      gaps += frame->pixels == nullptr;
      expected << "photograph " << serial << ' ' << k << ' '
               << (frame->pixels ? digest_of(*to_rgb(*frame)) : std::string("gap")) << '\n';
      if (const Result<Image> matte = load_png(layout.matte(serial, k)); matte)
        expected << "matte " << serial << ' ' << k << ' ' << digest_of(*matte) << '\n';
    }
  }
  for (int k = 0; k < 5; ++k)
    if (const Result<Mesh> mesh = load_ply(layout.mesh(k)); mesh)
      expected << "mesh " << k << ' ' << digest_of(*mesh) << '\n';
  ASSERT_GT(gaps, 0) << "no frame was dropped";
  ASSERT_THAT(expected.str(), AllOf(HasSubstr("matte "), HasSubstr("mesh ")));
  EXPECT_EQ(python_says("take", take), expected.str());
}

TEST_F(PythonReader, ProjectsThroughEveryLens) {
  Rig rig;
  const std::vector<Lens> lenses = {
      std::monostate{}, BrownConrady{.k1 = -0.2, .k2 = 0.05, .p1 = 1e-3, .p2 = -2e-3, .k3 = 0.01},
      BrownConrady{.k1 = 0.3, .k2 = 0.1, .k3 = 0.01, .k4 = 0.5, .k5 = 0.2, .k6 = 0.03},
      KannalaBrandt{.k1 = 0.02, .k2 = -0.01, .k3 = 0.003, .k4 = -0.001}};
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    RigCamera camera;
    camera.serial = text("cam", i);
    camera.model = {.width = 640,
                    .height = 480,
                    .fx = 700,
                    .fy = 690,
                    .cx = 321,
                    .cy = 239,
                    .skew = 1.5,
                    .lens = lenses[i]};
    camera.cam_from_world = {Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5).normalized(), {-1, 0.1, 2.5}};
    rig.cameras.push_back(camera);
  }
  const fs::path file = folder_ / "rig.json";
  ASSERT_THAT(save_rig(rig, file), IsOk());
  std::istringstream lines(python_says("rig", file));
  int before = 0, behind = 0;
  std::vector<Eigen::Vector3d> points;  // those of read_a_take.py
  for (const double x : {-0.4, 0.1})
    for (const double y : {-0.3, 0.2})
      for (const double z : {0.4, 1.6}) points.emplace_back(x, y, z);
  points.emplace_back(0, -5, 1);
  points.emplace_back(0, 5, 1);
  for (const RigCamera& camera : rig.cameras)
    for (const Eigen::Vector3d& point : points) {
      std::string word, serial, u, v;
      ASSERT_TRUE(lines >> word >> serial >> u >> v);
      EXPECT_EQ(serial, camera.serial);
      const auto pixel = project(camera.model, camera.cam_from_world * point);
      ASSERT_EQ(pixel.has_value(), u != "-");
      (pixel ? before : behind) += 1;
      if (!pixel) continue;
      EXPECT_NEAR(std::stod(u), pixel->x(), 1e-9) << serial;
      EXPECT_NEAR(std::stod(v), pixel->y(), 1e-9) << serial;
    }
  EXPECT_EQ(before, 4 * 9);
  EXPECT_EQ(behind, 4);
}

TEST_F(PythonReader, ReadsSoundSampleBySampleAndWhatLiesOverThePictures) {
  for (const int bits : {16, 24}) {
    const TempFolder folder;
    const fs::path take = small_take(folder, 2);
    EXPECT_THAT(python_says("extras", take),
                AllOf(HasSubstr("added cam05 None\n"), Not(HasSubstr("Added(")), Not(HasSubstr("sound"))));
    const capture::SoundTrack track{.name = "mic", .rate = 8000, .channels = 2, .bits = bits, .from = "test"};
    ASSERT_NO_FATAL_FAILURE(capture::record(TakeLayout(take), track, 20'000, {120'000'000}, 50));
    const capture::AddedFile added{.cameras = {{"cam01", {.left = 3, .overlays = {{4, 5, 20, 8}}}}}};
    ASSERT_THAT(capture::save_added(added, TakeLayout(take)), IsOk());
    std::vector<std::int32_t> samples;
    for (int second = 0; second * 8000 < 20'000; ++second)
      for (const float level :
           capture::patterned(second * 8000, std::min(8000, 20'000 - second * 8000), track.channels))
        samples.push_back(static_cast<std::int32_t>(level * static_cast<float>(1 << (bits - 1))));
    const std::string said = python_says("extras", take);
    EXPECT_THAT(
        said, HasSubstr("added cam00 None\nadded cam01 Added(bars=(3, 0, 0, 0), overlays=((4, 5, 20, 8),))"));
    EXPECT_THAT(said, HasSubstr(text("sound mic 8000 ", bits, " 20000x2 ", hash_of(samples), "\n")));
    EXPECT_THAT(said, HasSubstr("stamp 0 120000000 0\nstamp 8000 1119950002 0\n"));
    capture::AddedFile shown = added;
    shown.hidden = false;
    ASSERT_THAT(capture::save_added(shown, TakeLayout(take)), IsOk());
    EXPECT_THAT(python_says("extras", take), HasSubstr("added cam01 None"));
    std::ofstream(take / "mic.mka", std::ios::trunc) << "no sound";
    EXPECT_THAT(python_says("extras", take), AllOf(HasSubstr("BadTake:"), HasSubstr("mic.mka")));
  }
}

// By another program's encoder, each row by the filter of its name.
TEST_F(PythonReader, ReadsPngsOfEveryFilter) {
  for (const std::string filter : {"none", "sub", "up", "avg", "paeth", "mixed"})
    for (const std::string pixels : {"gray", "rgb24", "rgba"}) {
      const fs::path file = folder_ / (filter + pixels + ".png");
      ASSERT_EQ(
          run_command(text("ffmpeg -v error -f lavfi -i testsrc=size=61x43:rate=1 -frames:v 1 -pix_fmt ",
                           pixels, " -pred ", filter, " '", file.string(), "'"))
              .code,
          0);
      const Result<Image> ours = load_png(file);
      ASSERT_THAT(ours, IsOk());
      EXPECT_EQ(python_says("png", file), text("png ", digest_of(*ours), "\n")) << filter << ' ' << pixels;
    }
}

TEST_F(PythonReader, SaysWhichFileIsMissingCutOrOfAnotherKind) {
  EXPECT_THAT(python_says("take", folder_ / "none"), AllOf(HasSubstr("BadTake:"), HasSubstr("take.json")));
  const fs::path take = small_take(folder_, 1);
  const auto says_of = [&](const std::string& name, const std::string& bytes) {
    std::ifstream in(take / name, std::ios::binary);
    const std::string kept((std::istreambuf_iterator<char>(in)), {});
    std::ofstream(take / name, std::ios::binary) << bytes;
    const std::string said = python_says("take", take);
    std::ofstream(take / name, std::ios::binary) << kept;
    return said;
  };
  for (const std::string broken : {"", "{", "[]", "{\"floatstage_take\": 7}"})
    EXPECT_THAT(says_of("take.json", broken), AllOf(HasSubstr("BadTake:"), HasSubstr("take.json"))) << broken;
  EXPECT_THAT(says_of("rig.json", "{\"floatstage_rig\": 1, \"cameras\": []}"), HasSubstr("SHA-256"));
  const std::string side = "cam00.frames.csv";
  EXPECT_THAT(says_of(side, "a,b\n"), AllOf(HasSubstr("BadTake:"), HasSubstr(side)));
  EXPECT_THAT(
      says_of(side, "sequence,device_time_ns,studio_time_ns,exposure_ns,status,media_index\n0,,x,,ok,0\n"),
      AllOf(HasSubstr("BadTake:"), HasSubstr("line 2")));
  EXPECT_THAT(says_of("cam00.mkv", ""), AllOf(HasSubstr("BadTake:"), HasSubstr("cam00.mkv")));

  const Image picture(30, 20, 3, 90);
  const fs::path png = folder_ / "p.png";
  ASSERT_THAT(save_png(picture, png), IsOk());
  std::ifstream in(png, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (const std::size_t keep :
       {std::size_t{0}, std::size_t{8}, std::size_t{30}, whole.size() / 2, whole.size() - 13}) {
    std::ofstream(png, std::ios::binary) << whole.substr(0, keep);
    EXPECT_THAT(python_says("png", png), AllOf(HasSubstr("BadTake:"), HasSubstr("p.png"))) << keep;
  }
}

}  // namespace
}  // namespace floatstage
