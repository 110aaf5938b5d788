// Every rig that import or a session gives by default, in the four formats that other programs read: at most
// a thousandth of a pixel off where that program sees it, or refused with what to do instead.

#include <cstdio>
#include <functional>
#include <regex>

#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "calib/formats/refit.h"
#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/calibrate/new_session.h"
#include "pipeline/calibrate/scene.h"
#include "pipeline/calibrate/session_observations.h"
#include "tests/calib/action_lens.h"
#include "tests/calib/foreign_views.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using calib::ForeignRig;
using calib::RigFormat;

constexpr double kSame = 1e-3;  // px

Result<Rig> imported(const char* set, const char* file, const char* format, int width, int height) {
  Result<ForeignRig> read =
      calib::read_rig({.format = format, .path = real_data(set) / file, .metres_per_unit = 0.1});
  if (!read) return forward(read);
  for (RigCamera& c : read->rig.cameras)  // import takes the size from the pictures
    if (c.model.width == 0) c.model.width = width, c.model.height = height;
  return std::move(read->rig);
}

Result<Rig> solved_from(const Session& session) {
  const TempFolder folder;
  Result<SessionObservations> seen = collect(session, "", 0);
  if (!seen) return forward(seen);
  if (session.markerless)
    if (Result<void> ok = add_scene(session, folder / "colmap", 0, nullptr, *seen); !ok) return forward(ok);
  calib::CalibrationOptions options = session.options;
  options.holdout_every = 0;
  Result<calib::Calibration> solved = calib::calibrate(seen->observations, options);
  if (!solved) return forward(solved);
  return std::move(solved->rig);
}

Result<Rig> of_session(const char* name) {
  const Result<Session> session = load_session(source_folder() / "config/calibration" / name);
  if (!session) return forward(session);
  return solved_from(*session);
}

// A folder of pictures, without a word of ours.
Result<Rig> of_new_session(const char* set) {
  const TempFolder folder;
  const Result<NewSession> drafted = draft_session(real_data(set), folder.path(), {});
  if (!drafted) return forward(drafted);
  if (Result<void> ok = write_file(folder / "session.toml", drafted->toml); !ok) return forward(ok);
  const Result<Session> session = load_session(folder / "session.toml");
  if (!session) return forward(session);
  return solved_from(*session);
}

Result<Rig> of_a_waved_board(const Rig& truth, std::optional<int> radial) {
  const calib::CaptureOptions options{.frames = 40, .extent = 0.8, .frame_seconds = 0.4};
  calib::Observations seen =
      capture(truth, calib::two_sided_board(9, 7, 0.06, 0.005), wandering(options), options);
  for (calib::CalibrationCamera& c : seen.cameras) c.terms.radial = radial;
  Result<calib::Calibration> solved = calib::calibrate(seen, {.holdout_every = 0});
  if (!solved) return forward(solved);
  return std::move(solved->rig);
}

Result<Rig> of_action_cameras() {
  Rig truth = calib::ring_rig(3, 1.4, 1.1);
  for (RigCamera& c : truth.cameras) {
    c.model.fx = c.model.fy = 760;
    c.model.lens = calib::kActionLens;
  }
  return of_a_waved_board(truth, 6);
}

struct DefaultRig {
  const char* name;
  const char* set;  ///< null: synthetic
  bool quick;
  std::function<Result<Rig>()> make;
};

void PrintTo(const DefaultRig& rig, std::ostream* out) { *out << rig.name; }

std::vector<DefaultRig> default_rigs() {
  return {
      {"ring of cameras, waved board", nullptr, true,
       [] { return of_a_waved_board(calib::ring_rig(4), std::nullopt); }},
      {"fisheyes and a long lens, waved board", nullptr, true,
       [] { return of_a_waved_board(calib::mixed_rig(), std::nullopt); }},
      {"action cameras, radial = 6, waved board", nullptr, true, of_action_cameras},
      {"green-dome, imported", "green-dome", true,
       [] { return imported("green-dome", "calibration.txt", "dome", 1024, 768); }},
      {"green-dome-wd, imported", "green-dome-wd", true,
       [] { return imported("green-dome-wd", "calibration.txt", "dome", 1024, 768); }},
      {"dynamic-basketball, imported", "dynamic-basketball", true,
       [] { return imported("dynamic-basketball", "calibration.txt", "dome", 640, 360); }},
      {"middlebury-temple-ring, imported", "middlebury-temple-ring", true,
       [] { return imported("middlebury-temple-ring", "templeR_par.txt", "middlebury", 640, 480); }},
      {"middlebury-dino-sparse-ring, imported", "middlebury-dino-sparse-ring", true,
       [] { return imported("middlebury-dino-sparse-ring", "dinoSR_par.txt", "middlebury", 640, 480); }},
      {"pose2sim-balancing, imported", "pose2sim-balancing", true,
       [] { return imported("pose2sim-balancing", "calibration/Calib.qca.txt", "qualisys", 0, 0); }},
      {"lightfield-shop, imported", "lightfield-shop", true,
       [] { return imported("lightfield-shop", "views", "lightfield", 0, 0); }},
      {"caliscope-4cam, calibrated", "caliscope-4cam", false,
       [] { return of_session("caliscope-4cam.toml"); }},
      {"pose2sim-balancing, calibrated", "pose2sim-balancing", false,
       [] { return of_session("pose2sim-balancing.toml"); }},
      {"middlebury-temple-ring, lens given", "middlebury-temple-ring", false,
       [] { return of_session("temple-ring.toml"); }},
      {"middlebury-temple-sparse-ring, calibrate new", "middlebury-temple-sparse-ring", false,
       [] { return of_new_session("middlebury-temple-sparse-ring"); }},
      {"green-dome, calibrate new", "green-dome", false, [] { return of_new_session("green-dome"); }},
  };
}

// How far off the other program sees it, and what that program is.
struct Seen {
  double px = 0;
  const char* by = "";
};

Seen seen_elsewhere(const Rig& rig, const RigFormat& format, const std::filesystem::path& out,
                    const TempFolder& folder) {
  if (format.name == "opencv")
    return {calib::furthest_by_opencv(rig, calib::read_by_opencv(out, rig)), "FileStorage, projectPoints"};
  if (format.name == "colmap") {
    EXPECT_THAT(make_folder(folder / "adjusted"), IsOk());
    if (const auto cost = calib::first_cost_of_colmap(rig, out, folder / "adjusted"))
      return {*cost, "bundle_adjuster, RMS"};
  }
  // No program of Debian's reads these files: our reader's numbers, OpenCV's lens.
  const Result<ForeignRig> back = format.read(out, calib::kMetresPerUnit);
  EXPECT_THAT(back, IsOk());
  if (!back) return {1e9, ""};
  return {calib::furthest_by_opencv(rig, back->rig), "projectPoints"};
}

// A camchain has no world: its first camera is it.
Rig in_world_of(const RigFormat& format, Rig rig, const Rigid3& first) {
  if (format.name != "kalibr") return rig;
  for (RigCamera& c : rig.cameras) c.cam_from_world = c.cam_from_world * first.inverse();
  return rig;
}

class ExportTable : public testing::TestWithParam<DefaultRig> {};
INSTANTIATE_TEST_SUITE_P(Rigs, ExportTable, testing::ValuesIn(default_rigs()), [](const auto& given) {
  std::string name = given.param.name;
  std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
  return name;
});

TEST_P(ExportTable, EveryFormatIsSeenWhereWeSeeItOrRefusesWithTheRemedy) {
  const DefaultRig& given = GetParam();
  FLOATSTAGE_LONG_FORM(!given.quick);
  if (given.set) FLOATSTAGE_NEEDS_DATA(real_data(given.set));
  const Result<Rig> rig = given.make();
  ASSERT_THAT(rig, IsOk());
  std::string row = text("| ", given.name, " |");
  for (const RigFormat& format : calib::rig_formats()) {
    if (format.name != "colmap" && format.name != "opencv" && format.name != "kalibr" &&
        format.name != "qualisys")
      continue;
    SCOPED_TRACE(format.name);
    const Result<calib::FittedRig> fitted = calib::fit_to_format(*rig, format.holds, format.name, kSame);
    if (!fitted) {
      EXPECT_THAT(fitted, FailsWith(ErrorCode::Unsupported, "camera '"));
      const std::string& sentence = fitted.error().message;
      EXPECT_TRUE(std::regex_search(sentence, std::regex("calibrate with|write "))) << sentence;
      std::printf("%s, %s: %s\n", given.name, std::string(format.name).c_str(), sentence.c_str());
      row += " refused |";
      continue;
    }
    const TempFolder folder;
    const bool is_file = format.name == "kalibr" || format.name == "qualisys";
    const std::filesystem::path out = folder / (!is_file                  ? "out"
                                                : format.name == "kalibr" ? "camchain.yaml"
                                                                          : "rig.qca.txt");
    std::vector<std::string> pictures;
    for (const RigCamera& c : rig->cameras) pictures.push_back(c.serial + ".png");
    ASSERT_THAT(format.write(fitted->rig, pictures, out), IsOk());
    const Seen seen =
        seen_elsewhere(in_world_of(format, *rig, fitted->rig.cameras[0].cam_from_world), format, out, folder);
    EXPECT_LE(seen.px, kSame) << seen.by;
    double residual = 0;
    for (const Measured& r : fitted->residual_px) residual = std::max(residual, r ? *r : 0);
    row += text(' ', seen.px < 1e-6 ? std::string("< 1e-6") : text(std::round(1e7 * seen.px) / 1e7),
                residual > 0 ? " (fitted again)" : "", " |");
  }
  std::printf("%s\n", row.c_str());
}

}  // namespace
}  // namespace floatstage::pipeline
