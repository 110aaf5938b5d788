// `floatstage calibrate SESSION` as an operator meets it: what goes wrong is named, and nothing that was
// there is lost.

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/exit_codes.h"
#include "calib/board.h"
#include "capture/media_file.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "tests/calib/failing_captures.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr const char* kBefore = "what was there before";

// A folder with a session and with the results of yesterday.
class CalibrateVerb : public testing::Test {
 protected:
  CalibrateVerb() {
    std::filesystem::create_directory(folder_ / "report");
    for (const char* name : {"rig.json", "R.json", "report/calibration.html", "report/calibration.json"})
      folder_.write(name, kBefore);
  }

  Result<void> run(const std::string& toml) {
    const std::string session = folder_.write("session.toml", toml).string();
    const auto in = [&](const char* name) { return (folder_ / name).string(); };
    CLI::App app;
    Chosen chosen;
    add_calibrate_session(app, chosen);
    std::vector<std::string> arguments = {session,      "--out",  in("rig.json"), "--report",
                                          in("report"), "--json", in("R.json")};
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 takes them
    app.parse(arguments);
    return chosen.run();
  }

  std::string content(const char* name) const { return read_file(folder_ / name).value(); }

  void expect_error(const std::string& toml, ErrorCode code, int exit, const std::string& words) {
    const std::vector<std::string> names = folder_.names();
    const Result<void> result = run(toml);
    EXPECT_THAT(result, FailsWith(code, words));
    EXPECT_EQ(exit_code(code), exit);
    for (const char* name : {"rig.json", "R.json", "report/calibration.html", "report/calibration.json"})
      EXPECT_EQ(content(name), kBefore) << name << " was overwritten";
    for (const std::string& name : folder_.names())
      EXPECT_TRUE(name == "session.toml" || std::count(names.begin(), names.end(), name) == 1)
          << name << " was left behind";
  }

  std::filesystem::path picture(const std::string& name, int width = 64) {
    EXPECT_THAT(make_folder((folder_ / name).parent_path()), IsOk());
    Image image(width, 48, 3);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < width; ++x)
        *image.at(x, y) = static_cast<std::uint8_t>((x * 37 + y * 101 + name[0]) % 251);
    EXPECT_THAT(save_png(image, folder_ / name), IsOk());
    return folder_ / name;
  }

  std::filesystem::path video(const std::string& name, int frames) {
    const auto writer = capture::VideoWriter::create(folder_ / name, 64, 48, 30);
    EXPECT_THAT(writer, IsOk());
    for (int f = 0; f < frames; ++f) {
      Image image(64, 48, 3);
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
          *image.at(x, y) = static_cast<std::uint8_t>((x * 5 + y * 3 + f * 20 + name[0]) % 256);
      EXPECT_THAT((*writer)->write(image), IsOk());
    }
    EXPECT_THAT((*writer)->finish(), IsOk());
    return folder_ / name;
  }

  void cut(const std::filesystem::path& file, double share) {
    const std::string bytes = read_file(file).value();
    EXPECT_THAT(write_file(file, bytes.substr(
                                     0, static_cast<std::size_t>(share * static_cast<double>(bytes.size())))),
                IsOk());
  }

  TempFolder folder_;
};

const std::string kTarget = "target = \"chessboard columns=8 rows=5 square=30mm\"\n";
std::string two_cameras(const std::string& left, const std::string& right) {
  return kTarget + "[[cameras]]\nserial = \"left\"\n" + left + "\n[[cameras]]\nserial = \"right\"\n" + right +
         "\n";
}

TEST_F(CalibrateVerb, NamesAMissingSession) {
  CLI::App app;
  Chosen chosen;
  add_calibrate_session(app, chosen);
  app.parse((folder_ / "none.toml").string());
  EXPECT_THAT(chosen.run(), FailsWith(ErrorCode::NotFound, "none.toml"));
  EXPECT_EQ(exit_code(ErrorCode::NotFound), 4);
}

TEST_F(CalibrateVerb, NamesTheLineOfATypingMistake) {
  expect_error("traget = \"chessboard columns=8 rows=5 square=30mm\"\n", ErrorCode::BadData, 6,
               "session.toml: line 1: unknown key 'traget'");
  expect_error(kTarget + "[[cameras]\n", ErrorCode::BadData, 6, "session.toml: line 2: not TOML");
}

TEST_F(CalibrateVerb, NamesTheCameraOfAnEmptyFolder) {
  std::filesystem::create_directory(folder_ / "a");
  std::filesystem::create_directory(folder_ / "b");
  expect_error(two_cameras("images = \"a\"", "images = \"b\""), ErrorCode::NotFound, 4,
               "camera 'left': there is no picture in");
}

TEST_F(CalibrateVerb, NamesTheCameraOfAMissingFile) {
  picture("a/1.png");
  expect_error(two_cameras("images = \"a\"", "images = \"b\""), ErrorCode::NotFound, 4, "camera 'right': ");
  expect_error(two_cameras("images = \"a\"", "video = \"b.mp4\""), ErrorCode::NotFound, 4, "b.mp4");
}

TEST_F(CalibrateVerb, NamesAPictureThatIsCutOff) {
  for (int i = 0; i < 3; ++i) picture(text("a/", i, ".png")), picture(text("b/", i, ".png"));
  cut(folder_ / "b/1.png", 0.5);
  expect_error(two_cameras("images = \"a\"", "images = \"b\""), ErrorCode::BadData, 6, "1.png");
  cut(folder_ / "b/1.png", 0);
  expect_error(two_cameras("images = \"a\"", "images = \"b\""), ErrorCode::BadData, 6, "1.png");
}

TEST_F(CalibrateVerb, NamesAVideoThatIsCutOff) {
  video("a.mp4", 6), video("b.mp4", 6);
  cut(folder_ / "b.mp4", 0.6);
  expect_error(two_cameras("video = \"a.mp4\"", "video = \"b.mp4\""), ErrorCode::BadData, 6, "b.mp4");
}

TEST_F(CalibrateVerb, NamesVideosOfUnequalLength) {
  video("a.mp4", 6), video("b.mp4", 5);
  expect_error(two_cameras("video = \"a.mp4\"", "video = \"b.mp4\""), ErrorCode::BadData, 6,
               "camera 'right' has 5 pictures, camera 'left' has 6");
}

TEST_F(CalibrateVerb, NamesPicturesOfUnequalSize) {
  picture("a/1.png"), picture("a/2.png", 32);
  picture("b/1.png"), picture("b/2.png", 32);
  expect_error(two_cameras("images = \"a\"", "images = \"b\""), ErrorCode::BadData, 6,
               "picture 1 is 32x48, but the first one is 64x48");
}

TEST_F(CalibrateVerb, NamesTwoCamerasThatWereGivenOneFolder) {
  picture("a/1.png"), picture("a/2.png");
  expect_error(two_cameras("images = \"a\"", "images = \"a\""), ErrorCode::InvalidArgument,
               exit_code(ErrorCode::InvalidArgument), "cameras 'left' and 'right' were both given");
}

TEST_F(CalibrateVerb, SaysWhenNoPictureShowsTheTarget) {
  picture("a/1.png"), picture("b/1.png");
  expect_error(two_cameras("images = \"a\"", "images = \"b\""), ErrorCode::BadData, 6,
               "no picture of any camera shows a target");
}

TEST_F(CalibrateVerb, RefusesNumbersThatAreNone) {
  calib::Observations seen = failing_capture(calib::CalibrationFailure::PlanarMotion);
  std::string json = calib::to_json(seen);
  const std::size_t at = json.find("1280");
  ASSERT_NE(at, std::string::npos);
  for (const char* number : {"NaN", "1e999", "null"}) {
    std::string bad = json;
    folder_.write("seen.json", bad.replace(at, 4, number));
    expect_error("observations = \"seen.json\"\n", ErrorCode::BadData, 6, "seen.json");
  }
  folder_.write("seen.json", json.substr(0, json.size() / 2));
  expect_error("observations = \"seen.json\"\n", ErrorCode::BadData, 6, "seen.json");
  folder_.write("seen.json", json);
  folder_.write("known.json", "{\"version\": 1, \"cameras\": [{\"serial\": \"cam0\", \"fx\": NaN}]}");
  expect_error("observations = \"seen.json\"\n[known]\nfile = \"known.json\"\nposes = \"start\"\n",
               ErrorCode::BadData, 6, "known.json");
  expect_error("observations = \"seen.json\"\n[bars]\nrms_px = nan\n", ErrorCode::BadData, 6, "line 3");
}

TEST_F(CalibrateVerb, WritesTheRigOfASoundCapture) {
  const Rig truth = calib::ring_rig(3);
  folder_.write("seen.json",
                calib::to_json(calib::capture(truth, calib::two_sided_board(7, 5, 0.08, 0.005),
                                              calib::wandering(calib::kStills), calib::kStills)));
  ASSERT_THAT(run("observations = \"seen.json\"\n[bars]\nrotation_sigma_degrees = 0.3\n"), IsOk());
  const nlohmann::json r = nlohmann::json::parse(content("R.json"));
  EXPECT_TRUE(r["pass"].get<bool>());
  for (const char* key : {"cameras", "scale", "failures", "seconds"}) EXPECT_TRUE(r.contains(key)) << key;
  for (const char* key : {"rms_mm", "bias_mm"}) EXPECT_TRUE(r["scale"].contains(key)) << key;
  ASSERT_EQ(r["cameras"].size(), 3u);
  for (const char* key : {"serial", "rms_px", "p95_px", "holdout_px", "sigma"})
    EXPECT_TRUE(r["cameras"][2].contains(key)) << key;
  EXPECT_EQ(content("report/calibration.json"), content("R.json"));
  EXPECT_THAT(content("rig.json"), HasSubstr("cam2"));
}

// Each of the failures that a small reprojection error hides: the verb fails, both reports name it, the rig
// stays.
class NamedByTheReport : public CalibrateVerb,
                         public testing::WithParamInterface<calib::CalibrationFailure> {};
INSTANTIATE_TEST_SUITE_P(
    Failures, NamedByTheReport,
    testing::Values(calib::CalibrationFailure::ConstantDepth, calib::CalibrationFailure::PlanarMotion,
                    calib::CalibrationFailure::SwappedRowsColumns, calib::CalibrationFailure::WrongSquareSize,
                    calib::CalibrationFailure::MirroredBoard, calib::CalibrationFailure::LateCamera),
    [](const auto& given) {
      std::string name = name_of(given.param);
      std::erase(name, '-');
      return name;
    });

TEST_P(NamedByTheReport, AsPageAndAsJson) {
  folder_.write("seen.json", calib::to_json(calib::failing_capture(GetParam())));
  EXPECT_THAT(run("observations = \"seen.json\"\n"), FailsWith(ErrorCode::BadData, "does not pass"));
  const nlohmann::json r = nlohmann::json::parse(content("R.json"));
  EXPECT_FALSE(r["pass"].get<bool>());
  std::vector<std::string> names;
  for (const nlohmann::json& f : r["failures"]) names.push_back(f["name"]);
  EXPECT_THAT(names, Contains(name_of(GetParam())));
  EXPECT_THAT(content("report/calibration.html"), HasSubstr(text("<b>", name_of(GetParam()), "</b>")));
  EXPECT_EQ(content("rig.json"), kBefore);
}

TEST_F(CalibrateVerb, EndsWithItsSentenceWhereBothStreamsGoOneWay) {
  folder_.write("seen.json", calib::to_json(calib::failing_capture(calib::CalibrationFailure::LateCamera)));
  const std::string session = folder_.write("session.toml", "observations = \"seen.json\"\n").string();
  const std::string output = run_command(text(FLOATSTAGE_PROGRAM " calibrate ", session)).output;
  const std::size_t table = output.rfind("FAIL"), sentence = output.find("floatstage: " + session);
  ASSERT_NE(table, std::string::npos) << output;
  ASSERT_NE(sentence, std::string::npos) << output;
  EXPECT_GT(sentence, table);
  EXPECT_EQ(std::count(output.begin() + static_cast<std::ptrdiff_t>(sentence), output.end(), '\n'), 1);
}

}  // namespace
}  // namespace floatstage::apps
