// Imports that somebody prepared: each file of them replaced by each kind of trap, then the program's verb on
// it. Whatever it says, it ends in order, and leaves a whole take or nothing.

#include <functional>

#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "capture/media_file.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "core/text.h"
#include "tests/hostile/hostile_run.h"
#include "tests/hostile/traps.h"
#include "tests/hostile/zoom_folder.h"
#include "tests/pipeline/derive/sound_files.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr int kNotFound = 4, kBadData = 6;

/// What somebody sends, and the verb that is to read it.
struct Case {
  const char* name;
  std::function<void(const fs::path& folder)> make;
  std::function<Words(const fs::path& folder, const fs::path& out)> words;
  std::vector<const char*> files;     ///< that become traps
  std::vector<const char*> pictures;  ///< of those, that become bombs
  int untouched = 0;                  ///< its exit status as it should be
  const char* out = "out";            ///< what it makes
  std::string sends = "";             ///< a file that is made anew when another one is a trap…
  void (*send)(const fs::path& folder) = [](const fs::path&) {};  ///< … like this
};

void add_pictures(const fs::path& folder) {
  for (const char* serial : {"a", "b"})
    ASSERT_THAT(save_png(pipeline::test_picture(0, 0), folder / (std::string(serial) + ".png")), IsOk());
}

void add_film(const fs::path& file, int width = pipeline::kImportWidth,
              int height = pipeline::kImportHeight) {
  auto video = capture::VideoWriter::create(file, width, height, 25);
  ASSERT_THAT(video, IsOk());
  for (int f = 0; f < 3; ++f)
    ASSERT_THAT((*video)->write(pipeline::test_picture(0, f, width, height)), IsOk());
  ASSERT_THAT((*video)->finish(), IsOk());
}

/// A take of one camera, and what another recorder heard meanwhile.
void add_take_and_sound(const fs::path& folder) {
  capture::TakeWriterOptions options;
  options.codec = capture::TakeCodec::Raw;
  options.frame_rate = 25;
  const auto writer = capture::TakeWriter::create(folder / "take", pipeline::test_rig(1), options);
  ASSERT_THAT(writer, IsOk());
  for (int f = 0; f < 5; ++f) {
    FrameInfo info;
    info.camera = 0;
    info.sequence = static_cast<std::uint64_t>(f);
    info.exposure_start = {f * 40'000'000};
    ASSERT_THAT((*writer)->write(make_frame(info, pipeline::test_picture(0, f))), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
  std::vector<float> levels;
  for (int i = 0; i < 4000; ++i) levels.push_back(0.25f * static_cast<float>(i % 100) / 100);
  ASSERT_THAT(write_file(folder / "rec.wav", pipeline::wav_file(levels, 2, 8'000)), IsOk());
}

void add_middlebury(const fs::path& folder) {
  ASSERT_THAT(calib::write_middlebury(pipeline::test_rig(2), {"a.png", "b.png"}, folder / "x_par.txt"),
              IsOk());
}

std::function<Words(const fs::path&, const fs::path&)> import(const char* format, Words more = {}) {
  return [=](const fs::path& folder, const fs::path& out) {
    Words words = {"import", format, folder, "--images", folder, "-o", out, "--other-size", "scaled"};
    for (const std::string& word : more)
      words.push_back(word == "contours.json" ? (folder / word).string() : word);
    return words;
  };
}

/// A calibration of the fuzzers' seeds, under the name that its format wants, with pictures for two of its
/// cameras.
std::function<void(const fs::path&)> from_seed(const char* seed, const char* name, Words pictures) {
  return [=](const fs::path& folder) {
    fs::copy_file(source_folder() / "tests/fuzz/corpus" / seed, folder / name);
    for (const std::string& picture : pictures) {
      fs::create_directories((folder / picture).parent_path());
      ASSERT_THAT(save_png(pipeline::test_picture(0, 0), folder / picture), IsOk());
    }
  };
}

constexpr std::string_view kContours =
    R"({"categories": [{"id": 1, "name": "person"}], "images": [
  {"id": 7, "file_name": "a.png", "width": 32, "height": 24},
  {"id": 8, "file_name": "b.png", "width": 32, "height": 24}], "annotations": [
  {"id": 1, "image_id": 7, "category_id": 1, "iscrowd": 0, "segmentation": [[4.25, 3.5, 20, 3.75, 21.5, 19, 5, 20]]},
  {"id": 2, "image_id": 8, "category_id": 1, "iscrowd": 0, "segmentation": [[1, 2, 6, 0.5, 6, 3]]}]})";

constexpr std::string_view kMveMeta = R"([camera]
focal_length = 1
rotation = 1 0 0 0 1 0 0 0 1
translation = 0 0 3

[view]
id = 0
name = a view
)";

const std::vector<Case>& cases() {
  static const std::vector<Case> kCases = {
      {"middlebury",
       [](const fs::path& f) { add_middlebury(f), add_pictures(f); },
       import("middlebury"),
       {"x_par.txt", "b.png"},
       {"b.png"}},
      {"films",
       [](const fs::path& f) { add_middlebury(f), add_film(f / "a.mp4"), add_film(f / "b.mp4"); },
       import("middlebury"),
       {"b.mp4"},
       {"b.mp4"}},
      {"photographs",
       [](const fs::path& f) {
         add_middlebury(f);
         for (const char* name : {"a.jpg", "b.jpg"})
           ASSERT_THAT(write_file(f / name, encode_jpeg(pipeline::test_picture(0, 0), 90)), IsOk());
       },
       import("auto"),
       {"b.jpg"},
       {"b.jpg"}},
      {"colmap",
       [](const fs::path& f) {
         add_pictures(f);
         ASSERT_THAT(calib::write_colmap(pipeline::test_rig(2), {"a.png", "b.png"}, f), IsOk());
       },
       import("colmap"),
       {"cameras.bin", "images.bin"},
       {}},
      {"colmap_text",
       [](const fs::path& f) {
         add_pictures(f);
         ASSERT_THAT(calib::write_colmap(pipeline::test_rig(2), {"a.png", "b.png"}, f), IsOk());
         for (const char* name : {"cameras.bin", "images.bin"}) fs::remove(f / name);
       },
       import("colmap"),
       {"cameras.txt", "images.txt"},
       {}},
      {"opencv",
       [](const fs::path& f) {
         add_pictures(f);
         ASSERT_THAT(calib::write_easymocap(pipeline::test_rig(2), f), IsOk());
       },
       import("opencv"),
       {"intri.yml", "extri.yml"},
       {}},
      {"kalibr",
       [](const fs::path& f) {
         add_pictures(f);
         ASSERT_THAT(calib::write_kalibr(pipeline::test_rig(2), f / "camchain.yaml"), IsOk());
       },
       import("kalibr"),
       {"camchain.yaml"},
       {}},
      {"qualisys",
       [](const fs::path& f) {
         add_pictures(f);
         ASSERT_THAT(calib::write_qualisys(pipeline::test_rig(2), f / "x.qca.txt"), IsOk());
       },
       import("qualisys"),
       {"x.qca.txt"},
       {}},
      {"transforms",
       from_seed("transforms/opencv.json", "transforms.json", {"images/left.png", "right.png"}),
       import("transforms"),
       {"transforms.json", "right.png"},
       {}},
      {"openmvg",
       from_seed("openmvg/scene.json", "sfm_data.json", {"100_7100.png", "100_7102.png"}),
       import("openmvg"),
       {"sfm_data.json"},
       {}},
      {"mve",
       [](const fs::path& f) {
         for (const char* name : {"view_0000.mve", "view_0001.mve"}) {
           fs::create_directories(f / "views" / name);
           ASSERT_THAT(write_file(f / "views" / name / "meta.ini", kMveMeta), IsOk());
           ASSERT_THAT(save_png(pipeline::test_picture(0, 0), f / "views" / name / "undistorted.png"),
                       IsOk());
         }
       },
       [](const fs::path& f, const fs::path& out) {
         return Words{"import", "mve", f, "-o", out};
       },
       {"views/view_0001.mve/meta.ini", "views/view_0001.mve/undistorted.png"},
       {"views/view_0001.mve/undistorted.png"}},
      {"panoptic",
       from_seed("panoptic/studio.json", "calibration_a.json", {"00_00.png", "00_01.png"}),
       import("panoptic"),
       {"calibration_a.json"},
       {}},
      {"dome",
       from_seed("dome/two-cameras.txt", "calibration.txt", {"00.png", "01.png"}),
       import("dome"),
       {"calibration.txt"},
       {}},
      {"contours",
       [](const fs::path& f) {
         add_middlebury(f), add_pictures(f);
         ASSERT_THAT(write_file(f / "contours.json", kContours), IsOk());
       },
       import("middlebury", {"--contours", "contours.json"}),
       {"contours.json"},
       {}},
      {"clip",
       [](const fs::path& f) {
         add_film(f / "clip.mp4", 64, 48);
         Image mask(64, 48, 1);
         std::fill_n(mask.pixels.begin(), mask.pixels.size() / 2, std::uint8_t{255});
         ASSERT_THAT(save_png(mask, f / "mask.png"), IsOk());
       },
       [](const fs::path& f, const fs::path& out) {
         return Words{"matte", f / "clip.mp4", "--guide", f / "mask.png", "-o", out};
       },
       {"clip.mp4", "mask.png"},
       {"clip.mp4", "mask.png"},
       kBadData},  // a mask of half a picture is doubted
      {"portrait",
       [](const fs::path& f) {
         ASSERT_THAT(write_file(f / "portrait.jpg", encode_jpeg(pipeline::test_picture(0, 0), 90)), IsOk());
         Image trimap(pipeline::kImportWidth, pipeline::kImportHeight, 1);
         for (std::size_t p = 0; p < trimap.pixels.size(); ++p)
           trimap.pixels[p] = p % 3 == 0 ? 0 : p % 3 == 1 ? 128 : 255;
         ASSERT_THAT(save_png(trimap, f / "trimap.png"), IsOk());
       },
       [](const fs::path& f, const fs::path& out) {
         return Words{"matte-image", f / "portrait.jpg", "--trimap", f / "trimap.png", "-o", out};
       },
       {"portrait.jpg", "trimap.png"},
       {"portrait.jpg", "trimap.png"}},
      {"chroma",
       write_zoom_folder,
       [](const fs::path& f, const fs::path& out) {
         return Words{"matte-image", f / kClosePhoto, "--matte", "chroma", "-o", out};
       },
       {},
       {kClosePhoto},
       kNotFound},  // no cloth
      {"photo_graph",
       write_zoom_folder,
       [](const fs::path& f, const fs::path& out) {
         return Words{"detail", "graph", f, "--cache", f / ".cache", "--json", out};
       },
       {kClosePhoto},
       {kClosePhoto}},
      {"photo_graph_with_a_cache",
       [](const fs::path& f) {
         write_zoom_folder(f);
         const HostileRun made = hostile_run(
             {FLOATSTAGE_PROGRAM, "detail", "graph", f, "--cache", f / ".cache", "--json", f / "made.json"},
             20);
         ASSERT_EQ(made.status, 0) << made.said;
       },
       [](const fs::path& f, const fs::path& out) {
         return Words{"detail", "graph", f, "--cache", f / ".cache", "--json", out};
       },
       {".cache/pairs.json"},
       {}},
      {"composed",
       write_zoom_folder,
       [](const fs::path& f, const fs::path& out) {
         return Words{"detail", "compose", f / kZoomGraph, "--zoom", "1.5", "-o", out};
       },
       {kZoomGraph, kClosePhoto},
       {kWidePhoto, kClosePhoto},
       0,
       "out.png",
       kZoomGraph,
       write_zoom_graph},
      {"sound_of_another_recorder",
       add_take_and_sound,
       [](const fs::path& f, const fs::path& out) {
         return Words{"take", "set-sound", f / "take", f / "rec.wav", "--at", "0", "-o", out};
       },
       {"rec.wav"},
       {"rec.wav"}},
      {"synthesized",
       write_zoom_folder,
       [](const fs::path& f, const fs::path& out) {
         return Words{"detail", "synthesize", f / kZoomGraph, "--zoom", "2", "-o", out};
       },
       {kZoomGraph, kClosePhoto},
       {kWidePhoto},
       0,
       "out.dzi",
       kZoomGraph,
       write_zoom_graph},
  };
  return kCases;
}

class HostileImport : public testing::TestWithParam<std::size_t> {
 protected:
  const Case& attacked() const { return cases()[GetParam()]; }

  /// Mattes of a clip that cannot be trusted are there all the same.
  bool is_doubted_clip(int status) const {
    return status == kBadData && attacked().untouched == kBadData && fs::exists(folder_ / "out/labels.json");
  }

  /// The verb on the case as it is now. Its exit status.
  int run(const std::string& what) {
    const std::string out = attacked().out;
    Words words = attacked().words(folder_ / "in", folder_ / out);
    words.insert(words.begin(), FLOATSTAGE_PROGRAM);
    const int status = expect_orderly(words, what);
    const bool whole = status == 0 || is_doubted_clip(status);
    EXPECT_EQ(fs::exists(folder_ / out), whole) << what;
    for (const std::string& name : folder_.names()) {
      if (name == "in") continue;
      EXPECT_TRUE(whole) << what << " leaves " << name;
      EXPECT_NE(name[0], '.') << what;
      fs::remove_all(folder_ / name);
    }
    return status;
  }

  void begin() {
    fs::remove_all(folder_ / "in");
    fs::create_directories(folder_ / "in");
    attacked().make(folder_ / "in");
  }

  /// The case with one of its files changed.
  void attack(const char* file, const char* trap, const std::function<void(const fs::path&)>& set) {
    begin();
    set(folder_ / "in" / file);
    if (file != attacked().sends) attacked().send(folder_ / "in");
    run(text(attacked().name, ": ", file, " is ", trap));
  }

  const TempFolder folder_;
};

TEST_P(HostileImport, EndsInOrderWithAWholeTakeOrNothing) {
  begin();
  EXPECT_EQ(run(text(attacked().name, " as it should be")), attacked().untouched);
  for (const char* file : attacked().files)
    for (const Trap& trap : traps())
      attack(file, trap.name, [&](const fs::path& f) { trap.set(f, *read_file(f)); });
  for (const char* file : attacked().pictures)
    for (const Bomb& bomb : media_bombs())
      attack(file, bomb.name, [&](const fs::path& f) { ASSERT_THAT(write_file(f, bomb.bytes), IsOk()); });
}

INSTANTIATE_TEST_SUITE_P(OfEveryKind, HostileImport, testing::Range<std::size_t>(0, cases().size()),
                         [](const auto& kind) { return cases()[kind.param].name; });

TEST(HostileXml, IsNotExpandedAndLeadsNowhere) {
  const TempFolder folder;
  const std::string begin = "<?xml version=\"1.0\"?>";
  std::string laughs = begin + "<!DOCTYPE c [<!ENTITY a0 \"ha\">";
  for (int i = 1; i < 40; ++i) laughs += text("<!ENTITY a", i, " \"&a", i - 1, ";&a", i - 1, ";\">");
  const std::string deep(400'000, 'x');
  std::string nested = begin;
  for (int i = 0; i < 300'000; ++i) nested += "<c>";
  const std::vector<std::string> bombs = {
      laughs + "]><calibration>&a39;</calibration>",
      begin + "<!DOCTYPE c [<!ENTITY f SYSTEM \"file:///dev/zero\">]><calibration>&f;</calibration>", nested,
      begin + "<calibration " + deep + "=\"1\"/>"};
  for (std::size_t i = 0; i < bombs.size(); ++i) {
    ASSERT_THAT(write_file(folder / "x.qca.txt", bombs[i]), IsOk());
    expect_orderly({FLOATSTAGE_PROGRAM, "import", "qualisys", folder.path(), "-o", folder / "out"},
                   text("XML bomb ", i));
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
}

}  // namespace
}  // namespace floatstage
