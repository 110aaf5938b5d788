// `export web` in a headless Chromium, from file://: the same pictures as our own `linear`.
#include "pipeline/export/export_web.h"

#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/export/page_start.h"
#include "pipeline/export/photo_sheet.h"
#include "pipeline/export/web_frame.h"
#include "pipeline/export/web_page.h"
#include "pipeline/film.h"
#include "pipeline/subject.h"
#include "tests/pipeline/export/folder_server.h"
#include "tests/pipeline/export/processed_take.h"
#include "tests/support/browser.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Each;
using testing::Ge;
using testing::Not;

// Where the virtual camera stands, as the page has it and as our films have it.
PathKey key_at(double azimuth, double elevation, double distance, const Eigen::Vector3d& target) {
  PathKey key;
  key.target = target;
  key.eye = target + distance * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  return key;
}

Eigen::Vector3d vector_of(const json& j) {
  return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()};
}

json to_json_key(const PathKey& key) {
  const auto list = [](const Eigen::Vector3d& v) { return json{v.x(), v.y(), v.z()}; };
  return {{"eye", list(key.eye)}, {"target", list(key.target)}, {"up", list(key.up)}, {"fov_y", key.fov_y}};
}

// Our own `linear` of one frame from one place, RGBA.
Image drawn_here(capture::TakeReader& take, const PathKey& key, int frame, int width, int height) {
  FilmOptions film;
  film.width = width;
  film.height = height;
  film.seconds = 1.0 / film.frame_rate;
  film.frames = {frame};
  film.methods = {"linear"};
  film.renderer.back_end = render::BackEnd::Cpu;
  Image picture;
  const Result<FilmReport> done = render_film(take, CameraPath{{key}}, film, [&](FilmPicture p) {
    picture = std::move(p.renders.front());
    return Result<void>();
  });
  EXPECT_THAT(done, IsOk());
  return picture;
}

std::string from_base64(const std::string& encoded) {
  std::string out;
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : encoded) {
    static const std::string kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t value = kLetters.find(c);
    if (value == std::string::npos) break;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    have += 6;
    if (have >= 8) out.push_back(static_cast<char>(bits >> (have -= 8) & 255));
  }
  return out;
}

// The page's picture of the same.
Image drawn_there(Browser& browser, const PathKey& key, int frame, int width, int height) {
  browser.value(text("(window.answer = '', floatstage.picture(", frame, ", ", to_json_key(key).dump(), ", ",
                     width, ", ", height,
                     ").then(p => { window.answer = p; }, e => { window.answer = 'error ' + e; }), 0)"));
  EXPECT_TRUE(browser.becomes_true("window.answer !== ''", 60));
  const std::string answer = browser.value("window.answer").get<std::string>();
  const std::string head = "data:image/png;base64,";
  if (!answer.starts_with(head)) {
    ADD_FAILURE() << answer;
    return {};
  }
  const std::string png = from_base64(answer.substr(head.size()));
  const Result<Image> image = decode_png(std::as_bytes(std::span(png)), "the page's picture");
  EXPECT_THAT(image, IsOk());
  return image ? *image : Image();
}

struct Likeness {
  double psnr = 0;     // dB, where ours shows the subject
  double covered = 0;  // share of the picture that the subject is
};

Likeness likeness(const Image& ours, const Image& page) {
  if (ours.width != page.width || ours.height != page.height) return {};
  double sum = 0;
  std::size_t inside = 0;
  const std::size_t pixels = static_cast<std::size_t>(ours.width) * ours.height;
  for (std::size_t p = 0; p < pixels; ++p) {
    if (ours.pixels[p * ours.channels + 3] < 128) continue;
    ++inside;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = double(ours.pixels[p * ours.channels + k]) - page.pixels[p * page.channels + k];
      sum += d * d;
    }
  }
  if (inside == 0) return {};
  return {10 * std::log10(255.0 * 255.0 * 3 * static_cast<double>(inside) / std::max(sum, 1e-9)),
          static_cast<double>(inside) / static_cast<double>(pixels)};
}

class AnExportedPage : public testing::Test {
 protected:
  void make(const TakeSize& size) {
    take_ = processed_take(folder_, size);
    ExportWebOptions options;
    options.take = take_;
    options.out = folder_ / "page";
    for (int f = 0; f < size.frames; ++f) options.frames.push_back(f);
    options.path = CameraPath{{key_at(0, 0, 3, {0, 0, 1}), key_at(1, 0, 3, {0, 0, 1})}};
    options.path->keys.back().time = 1;
    const Result<ExportWebReport> report = export_web(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->frames, size.frames);
  }
  std::string url() const { return "file://" + (folder_ / "page/index.html").string(); }
  // Where a person asks to look at what the page looks like.
  static void keep(Browser& browser, const std::string& name) {
    if (const char* folder = std::getenv("FLOATSTAGE_PAGE_PICTURES"))
      browser.screenshot(fs::path(folder) / (name + ".png"));
  }
  static void keep(const Image& image, const std::string& name) {
    const char* const folder = std::getenv("FLOATSTAGE_PAGE_PICTURES");
    if (folder == nullptr || image.empty()) return;
    EXPECT_THAT(save_png(image, fs::path(folder) / (name + ".png")), IsOk());
  }
  TempFolder folder_;
  fs::path take_;
};

TEST_F(AnExportedPage, ShowsWhatLinearShows) {
  make({.cameras = 8, .frames = 2, .width = 320, .height = 240, .lens_k1 = -0.05});
  auto take = capture::TakeReader::open(take_);
  ASSERT_THAT(take, IsOk());
  const Eigen::Vector3d target = find_subject(**take).value().box.center();
  Browser browser(1280, 800);
  browser.open(url());
  ASSERT_TRUE(browser.becomes_true("window.floatstage && floatstage.shown === 0", 60));
  keep(browser, "page");
  const json start = browser.value("floatstage.take.start"), begun = browser.value("floatstage.key");
  const PageStart there{vector_of(start["target"]), vector_of(start["up"]), vector_of(start["east"]),
                        start["elevation"],         start["distance"],      start["fov_y"]};
  EXPECT_LT((vector_of(begun["eye"]) - there.eye()).norm(), 1e-9);
  EXPECT_LT((vector_of(begun["up"]) - Eigen::Vector3d::UnitZ()).norm(), 1e-6);
  int n = 0;
  for (const auto& [width, height] : {std::pair{1280, 800}, std::pair{390, 844}})
    for (const double azimuth : {0.2, 1.7, -2.3}) {
      const PathKey key = key_at(azimuth, 0.15, height > width ? 4.5 : 2.8, target);
      const Image ours = drawn_here(**take, key, n % 2, width, height),
                  page = drawn_there(browser, key, n % 2, width, height);
      const Likeness alike = likeness(ours, page);
      keep(ours, text("linear", n));
      keep(page, text("web", n));
      std::printf("%dx%d from %.1f: %.1f dB over %.1f %% of the picture\n", width, height, azimuth,
                  alike.psnr, 100 * alike.covered);
      EXPECT_GE(alike.psnr, 30) << width << "x" << height << " from " << azimuth;
      EXPECT_GT(alike.covered, 0.02);
      ++n;
    }
}

TEST_F(AnExportedPage, FliesThePathAsFilmsDo) {
  const fs::path folder = processed_take(folder_, {.frames = 3});
  const auto take = std::move(*capture::TakeReader::open(folder));
  const Subject subject = *find_subject(*take);
  const double rate = take->manifest().frame_rate;
  CameraPath path{{key_at(0, 0, 3, {0, 0, 1}), key_at(1, 0, 3, {0, 0, 0}), key_at(3, 0, 2, {0, 0, 1})}};
  path.keys[1].time = 1, path.keys[2].time = 2;
  path.keys[0].orbit = 1, path.keys[1].follow = true, path.keys[1].ease_in = 1;
  path.keys[0].take_time = path.keys[1].take_time = 2 / rate, path.keys[2].take_time = 0;
  ExportWebOptions options;
  options.take = folder, options.out = folder_ / "page", options.frames = {0, 2}, options.path = path;
  ASSERT_THAT(export_web(options), IsOk());
  std::string script = *read_file(options.out / "take.js");
  script = script.substr(script.find('{'));
  const json page = json::parse(script.substr(0, script.rfind('}') + 1));
  ASSERT_EQ(page["path"].size(), 101u);
  for (std::size_t i = 0; i < page["path"].size(); ++i) {
    const double time = static_cast<double>(i) / page["path_rate"].get<double>();
    json wanted = to_json_key(sample(path, time, subject.track));
    wanted["frame"] = shown_at(path, time, rate, options.frames);
    EXPECT_EQ(page["path"][i], wanted) << time;
  }
  EXPECT_EQ(page["path"][10]["frame"], 1) << "frozen at the second of the frames that are here";
  EXPECT_EQ(page["path"][100]["frame"], 0);
}

TEST_F(AnExportedPage, PlaysTurnsAndFitsATelephone) {
  make({.frames = 3});
  Browser browser(390, 844);
  browser.resize(390, 844);
  browser.open(url());
  ASSERT_TRUE(browser.becomes_true("window.floatstage && floatstage.shown === 0", 60));
  keep(browser, "telephone");
  EXPECT_EQ(browser.value("document.documentElement.scrollWidth"), browser.value("window.innerWidth"));
  EXPECT_THAT(browser
                  .value("[...document.querySelectorAll('#bar > :not([hidden])')].map(e => "
                         "Math.round(e.getBoundingClientRect().right))")
                  .get<std::vector<int>>(),
              Each(testing::Le(390)));
  // Everything that can be pressed has a name and is large enough for a finger.
  EXPECT_EQ(
      browser.value("[...document.querySelectorAll('button,input')].filter(e => !(e.textContent.trim() || "
                    "e.getAttribute('aria-label'))).length"),
      0);
  EXPECT_EQ(browser.value("[...document.querySelectorAll('button,input')].filter(e => !e.hidden && "
                          "e.getBoundingClientRect().height < 44).length"),
            0);
  const double before = browser.value("floatstage.azimuth");
  browser.value(
      "['pointerdown', 'pointermove', 'pointerup'].forEach((kind, i) => "
      "document.getElementById('stage').dispatchEvent(new PointerEvent(kind, {pointerId: 1, pointerType: "
      "'touch', clientX: 200 - 60 * (i > 0), clientY: 400, bubbles: true})))");
  EXPECT_GT(browser.value("floatstage.azimuth").get<double>(), before + 0.2) << "one finger turns";
  browser.click("#play");
  EXPECT_TRUE(browser.becomes_true("floatstage.shown > 0"));
  EXPECT_EQ(browser.value("document.getElementById('play').textContent"), "Pause");
  browser.click("#play");
  browser.click("#path");
  EXPECT_TRUE(
      browser.becomes_true("document.getElementById('path').getAttribute('aria-pressed') === 'false'"))
      << "the path ends by itself";
}

TEST_F(AnExportedPage, PlaysFromAServerAndAsksForNothingElsewhere) {
  make({.frames = 1});
  const FolderServer server(folder_ / "page");
  Browser browser(390, 844);
  browser.open(server.url() + "index.html");
  ASSERT_TRUE(browser.becomes_true("window.floatstage && floatstage.shown === 0", 60));
  // The browser keeps no such list for files of a disk.
  const std::vector<std::string> asked =
      browser.value("performance.getEntriesByType('resource').map(e => e.name)");
  EXPECT_THAT(asked, testing::SizeIs(Ge(8u)));
  EXPECT_THAT(asked, Each(testing::AnyOf(testing::StartsWith(server.url()), testing::StartsWith("data:"))));
}

TEST_F(AnExportedPage, SaysWhichFileIsMissing) {
  make({.frames = 1});
  fs::remove(folder_ / "page/frames/000000.js");
  Browser browser(390, 844);
  browser.open(url());
  EXPECT_TRUE(browser.becomes_true("document.getElementById('message').textContent.includes('000000.js')"));
}

// Of a rig whose world has another axis up than z: its cameras say which.
TEST(ExportWeb, BeginsUprightWhateverTheWorldCallsUp) {
  Rig rig;
  for (int i = 0; i < 6; ++i) {
    const double a = i * 0.4;
    rig.cameras.push_back(
        {text("c", i),
         CameraModel{
             .width = 400, .height = 300, .fx = 600, .fy = 600, .cx = 200, .cy = 150, .skew = 0, .lens = {}},
         look_at({3 * std::cos(a), 3 * std::sin(a), 1.5}, {0, 0, 1}, {0, 0, 1}),
         {}});
  }
  const Eigen::AlignedBox3d subject(Eigen::Vector3d(-0.4, -0.3, 0), Eigen::Vector3d(0.4, 0.3, 1.8));
  const PageStart usual = page_start(rig, subject);
  EXPECT_LT((usual.up - Eigen::Vector3d::UnitZ()).norm(), 1e-6);
  EXPECT_NEAR(usual.eye().y(), 0, 1e-9) << "before the first camera";
  EXPECT_GT(usual.eye().z(), 0.9) << "as high as they stand";

  // The same stage with -y up: x stays, z becomes -y.
  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX())),
                    Eigen::Vector3d::Zero()};
  for (RigCamera& camera : rig.cameras) camera.cam_from_world = camera.cam_from_world * turn.inverse();
  const Eigen::AlignedBox3d turned(Eigen::Vector3d(-0.4, -1.8, -0.3), Eigen::Vector3d(0.4, 0, 0.3));
  const PageStart other = page_start(rig, turned);
  EXPECT_LT((other.up - turn * usual.up).norm(), 1e-6);
  EXPECT_LT((other.eye() - turn * usual.eye()).norm(), 1e-6);
  EXPECT_LT((other.east - turn * usual.east).norm(), 1e-6);
}

TEST(ExportWeb, HoldsNoAddressOfAnotherMachine) {
  for (const WebPageFile& file : web_page_files())
    EXPECT_THAT(std::string(file.content), Not(testing::ContainsRegex("https?://"))) << file.name;
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(ExportWeb, RefusesWhatCannotBeAndLeavesNothingBehind) {
  TempFolder folder;
  ExportWebOptions options;
  options.take = folder / "nobody";
  options.out = folder / "page";
  EXPECT_THAT(export_web(options), FailsWith(ErrorCode::InvalidArgument, "no frame"));
  options.frames = {0};
  EXPECT_THAT(export_web(options), FailsWith(ErrorCode::NotFound, "nobody"));
  options.quality = 101;
  EXPECT_THAT(export_web(options), FailsWith(ErrorCode::InvalidArgument, "--quality"));
  EXPECT_THAT(folder.names(), testing::IsEmpty());
}

// A sphere-like body before cameras of any size: tiles show the photograph's own pixels and fit the sheet.
TEST(PhotoSheets, FitTheirSizeByHalvingPhotographs) {
  StraightInstant instant;
  instant.mesh = {{{-0.5F, 0, -0.5F}, {0.5F, 0, -0.5F}, {0, 0, 0.5F}}, {0, 1, 2}};
  for (int i = 0; i < 3; ++i) {
    CameraModel model{
        .width = 400, .height = 300, .fx = 600, .fy = 600, .cx = 200, .cy = 150, .skew = 0, .lens = {}};
    instant.rig.cameras.push_back({text("c", i), model, look_at({0.1 * i, -3, 0}, {0, 0, 0}, {0, 0, 1}), {}});
    instant.pictures.emplace_back(400, 300, 3, static_cast<std::uint8_t>(50 * (i + 1)));
    instant.mattes.emplace_back();
  }
  instant.pictures[1].at(200, 150)[0] = 255;
  const PhotoSheet whole = photo_sheet(instant), small = photo_sheet(instant, 256);
  EXPECT_EQ(whole.tiles[1]->shrink, 1);
  const SheetTile t = *whole.tiles[1];
  EXPECT_EQ(*whole.picture.at(t.x + 200 - t.left, t.y + 150 - t.top), 255);
  EXPECT_EQ(*whole.picture.at(t.x + t.width, t.y), 255) << "no matte is all subject";
  EXPECT_GT(small.tiles[0]->shrink, 1);
  EXPECT_LE(small.picture.width, 256);
  EXPECT_LE(small.picture.height, 256);
  EXPECT_EQ(*small.picture.at(small.tiles[2]->x, small.tiles[2]->y), 150);
}

}  // namespace
}  // namespace floatstage::pipeline
