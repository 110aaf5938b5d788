#include "pipeline/film.h"

#include <cmath>
#include <map>
#include <span>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/orbit.h"
#include "pipeline/process/process.h"
#include "pipeline/scene_loader.h"
#include "render/drawn_from.h"
#include "render/gl_context.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

class AFilm : public testing::Test {
 protected:
  void SetUp() override {
    path_ = small_take(folder_, 2);
    ProcessOptions options{.take = path_, .matte = "chroma", .hull = recon::HullOptions{}};
    ASSERT_THAT(process_take(options), IsOk());
    take_ = std::move(*capture::TakeReader::open(path_));
    subject_ = *find_subject(*take_);
    film_.width = 160;
    film_.height = 120;
    film_.frame_rate = 4;
    film_.seconds = 2;
    film_.frames = {0, 1};
    film_.methods = {"floating"};
    film_.renderer.back_end = render::BackEnd::Cpu;
  }
  // One photograph and its stand-ins are not all there are.
  void blend(int count) { film_.renderer.cameras = count; }
  std::vector<FilmPicture> shoot() {
    std::vector<FilmPicture> pictures;
    const CameraPath path = orbit_around(take_->rig(), subject_, {.seconds = 2}).path;
    EXPECT_THAT(render_film(*take_, path, film_,
                            [&](FilmPicture picture) -> Result<void> {
                              pictures.push_back(std::move(picture));
                              return {};
                            }),
                IsOk());
    return pictures;
  }
  // With all photographs there are.
  Image alone(const FilmPicture& picture, const std::string& method = "floating") {
    render::Scene scene;
    EXPECT_THAT(scene.set(take_->rig(), *SceneLoader(*take_, film_.suppress_spill).load(picture.frame)),
                IsOk());
    const auto renderer = std::move(*render::make_renderer(method, render::BackEnd::Cpu));
    return render::download(*renderer->render(scene, picture.view, film_.renderer));
  }

  TempFolder folder_;
  std::filesystem::path path_;
  std::unique_ptr<capture::TakeReader> take_;
  Subject subject_;
  FilmOptions film_;
};

TEST_F(AFilm, DecodesOnlyThePhotographsOfAPictureAndDrawsTheSameOne) {
  blend(1);
  const std::vector<FilmPicture> pictures = shoot();
  ASSERT_EQ(pictures.size(), 8u);
  for (const FilmPicture& picture : pictures) {
    const Mesh mesh = SceneLoader(*take_, false).load(picture.frame)->mesh;
    EXPECT_LT(render::drawn_from(take_->rig(), mesh, picture.view, 1).size(), 6u);
    EXPECT_EQ(picture.renders[0].pixels, alone(picture).pixels) << picture.index;
  }
}

TEST_F(AFilm, DrawsFromPartsOfPhotographsWhatWholeOnesGive) {
  film_.methods = {"nearest", "linear", "floating"};
  film_.seconds = 0.5;
  for (const int shrink : {1, 3}) {  // pictures so small that coarser levels of the photographs are read
    film_.width = 160 / shrink, film_.height = 120 / shrink;
    const std::vector<FilmPicture> pictures = shoot();
    ASSERT_EQ(pictures.size(), 2u);
    for (const FilmPicture& picture : pictures) {
      const Mesh mesh = SceneLoader(*take_, false).load(picture.frame)->mesh;
      for (std::size_t m = 0; m < film_.methods.size(); ++m) {
        int pixels = 0;
        for (const PixelBox& part : render::parts_drawn_from(take_->rig().cameras[0], mesh,
                                                             std::span(&picture.view, 1), film_.methods[m]))
          pixels += part.width * part.height;
        EXPECT_LT(pixels, 160 * 120 * 5 / 9) << film_.methods[m];
        EXPECT_EQ(picture.renders[m].pixels, alone(picture, film_.methods[m]).pixels) << film_.methods[m];
      }
    }
  }
}

TEST_F(AFilm, TakesWholePhotographsForMethodsThatLookBeyondTheProxy) {
  const Mesh mesh = SceneLoader(*take_, false).load(0)->mesh;
  const View view = shoot().front().view;
  for (const char* method : {"filtered", "band-limited", "floating-static"})
    EXPECT_THAT(render::parts_drawn_from(take_->rig().cameras[0], mesh, std::span(&view, 1), method),
                testing::ElementsAre(PixelBox{0, 0, 160, 120}))
        << method;
}

TEST_F(AFilm, ShowsWhatThePathSaysFromWhereThePathSays) {
  CameraPath path = orbit_around(take_->rig(), subject_, {.seconds = 1}).path;
  path.keys.resize(3);
  const double frame = 1 / take_->manifest().frame_rate;
  path.keys.front().take_time = frame, path.keys[1].take_time = frame, path.keys.back().take_time = 0;
  path.keys.front().ease_out = 0.5, path.keys[1].orbit = 0;
  path.keys[1].follow = true;
  path.keys[1].eye -= subject_.track.at(frame), path.keys[1].target -= subject_.track.at(frame);
  film_.seconds = 0;  // the path's
  film_.frame_rate = 40;
  film_.methods = {"nearest"};
  int pictures = 0;
  EXPECT_THAT(render_film(*take_, path, film_,
                          [&](const FilmPicture& picture) -> Result<void> {
                            const double time = picture.index / film_.frame_rate;
                            const View view =
                                view_of(sample(path, time, subject_.track), 160, 120, subject_.box);
                            EXPECT_EQ(picture.view.view_from_world.matrix(), view.view_from_world.matrix());
                            EXPECT_EQ(picture.view.model.fx, view.model.fx);
                            const std::vector<int> frames = {0, 1};
                            EXPECT_EQ(picture.frame,
                                      frames[shown_at(path, time, take_->manifest().frame_rate, frames)]);
                            ++pictures;
                            return {};
                          }),
              IsOk());
  EXPECT_EQ(pictures, std::lround(path.duration() * 40));
}

TEST_F(AFilm, DrawsAPhotographWithoutAMatteAsWholeScenesDo) {
  const std::filesystem::path matte = TakeLayout(path_).matte("cam00", 0);
  ASSERT_TRUE(std::filesystem::remove(matte));
  blend(1);
  for (const FilmPicture& picture : shoot())
    EXPECT_EQ(picture.renders[0].pixels, alone(picture).pixels) << picture.index;
}

// Of the first and the fourth of six cameras parts.
std::vector<std::vector<PixelBox>> parts_of_two(const Mesh&) {
  return {{{40, 30, 50, 60}}, {}, {}, {{60, 10, 40, 30}, {50, 40, 20, 50}}, {}, {}};
}

TEST_F(AFilm, LoadsThePartsThatWereChosen) {
  SceneLoader loader(*take_, true);
  const SceneFrame whole = *loader.load(0);
  const auto scene = loader.load_parts(0, parts_of_two);
  ASSERT_THAT(scene, IsOk());
  const SceneParts& parts = std::get<SceneParts>(*scene);
  EXPECT_EQ(parts.mesh.positions, whole.mesh.positions);
  ASSERT_EQ(parts.photographs.size(), 2u);
  for (const PhotographPart& part : parts.photographs) {
    const auto camera = static_cast<std::size_t>(part.camera);
    EXPECT_TRUE(camera == 0 || camera == 3) << camera;
    const std::vector<PixelBox> boxes = parts_of_two({})[camera];
    EXPECT_EQ(part.box, around(boxes));
    const Image photograph = to_rgb(whole.images.frames[camera]).value();
    for (const PixelBox& box : boxes)
      for (int y = box.y; y < box.y + box.height; ++y)
        ASSERT_EQ(std::memcmp(part.photograph.at(box.x - part.box.x, y - part.box.y), photograph.at(box.x, y),
                              3 * static_cast<std::size_t>(box.width)),
                  0)
            << camera << ", row " << y;
    for (int y = 0; y < part.box.height; ++y)
      for (int x = 0; x < part.box.width; ++x)
        ASSERT_EQ(*part.matte.at(x, y), whole.mattes[camera].row(part.box.y + y)[part.box.x + x]);
  }
}

TEST_F(AFilm, TellsWhenASilhouetteIsNewerThanTheMeshEvenWhereItIsNotDrawn) {
  const std::filesystem::path matte = TakeLayout(path_).matte("cam01", 0);
  const std::filesystem::path other = TakeLayout(path_).matte("cam02", 0);
  std::filesystem::copy_file(other, matte, std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(SceneLoader(*take_, true).load_parts(0, parts_of_two), FailsWith(ErrorCode::NotFound, "cam01"));
}

TEST_F(AFilm, SaysWhatTheStagesOfOpenGlTakeWhereThatIsAsked) {
  const std::unique_ptr<render::GlContext> context = std::move(*render::GlContext::headless());
  film_.methods = {"linear"};
  const CameraPath path = orbit_around(take_->rig(), subject_, {.seconds = 2}).path;
  auto report = [&](render::BackEnd back_end, bool asked) {
    film_.renderer.back_end = back_end;
    film_.time_stages = asked;
    return *render_film(*take_, path, film_, [](FilmPicture) { return Result<void>(); });
  };
  EXPECT_TRUE(report(render::BackEnd::Cpu, true).stages.empty());
  EXPECT_TRUE(report(render::BackEnd::Gl, false).stages.empty());
  const FilmReport timed = report(render::BackEnd::Gl, true);
  ASSERT_EQ(timed.pictures, 8);
  std::map<std::string, render::StageTime> stages;
  for (const render::StageTime& stage : timed.stages) stages[stage.name] = stage;
  for (const char* name :
       {"uploads", "surface", "visibility", "weights", "blending", "outline", "reading back"})
    EXPECT_EQ(stages.count(name), 1U) << name;
  EXPECT_EQ(stages["visibility"].dispatches, timed.pictures);
  EXPECT_GT(stages["blending"].milliseconds, 0);
}

TEST_F(AFilm, TellsHowMuchOfItNobodySees) {
  const std::unique_ptr<render::GlContext> context = std::move(*render::GlContext::headless());
  film_.methods = {"linear"};
  film_.seconds = 0.5;
  const CameraPath around = orbit_around(take_->rig(), subject_, {.seconds = 2}).path;
  // From under the floor: nobody shows soles.
  PathKey key;
  key.target = subject_.box.center();
  key.eye = key.target - Eigen::Vector3d(0.1, 0, 3);
  const CameraPath below{{key}};
  auto sight = [&](const CameraPath& path, render::BackEnd back_end) {
    film_.renderer.back_end = back_end;
    return render_film(*take_, path, film_, [](FilmPicture) { return Result<void>(); })->sight;
  };
  const FilmSight seen = sight(around, render::BackEnd::Cpu), unseen = sight(below, render::BackEnd::Cpu);
  EXPECT_EQ(seen.pictures, 2);
  EXPECT_EQ(seen.doubt(), std::nullopt);
  EXPECT_GT(unseen.worst, 0.2);
  EXPECT_TRUE(unseen.doubt());
  EXPECT_NEAR(sight(below, render::BackEnd::Gl).worst, unseen.worst, 0.01);
  film_.renderer.output = render::RenderOutput::Visibility;
  EXPECT_EQ(sight(below, render::BackEnd::Cpu).pictures, 0) << "it is pictures of colours that are judged";
}

TEST_F(AFilm, OfThreeEyesHasTheOneOfOneEyeInItsMiddle) {
  film_.seconds = 0.5;
  const std::vector<FilmPicture> one = shoot();
  film_.array = {.views = 3, .baseline = 0.1};
  const std::vector<FilmPicture> three = shoot();
  ASSERT_EQ(three.size(), one.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(three[i].renders.size(), 3u);
    EXPECT_EQ(three[i].renders[1], one[i].renders[0]);
    EXPECT_NE(three[i].renders[0], three[i].renders[2]);
  }
}

TEST_F(AFilm, OfSeveralEyesIsOfOneMethodAndOfAtMostEight) {
  const CameraPath path = orbit_around(take_->rig(), subject_, {.seconds = 2}).path;
  const auto nothing = [](FilmPicture) -> Result<void> { return {}; };
  film_.array.views = 9;
  EXPECT_THAT(render_film(*take_, path, film_, nothing), FailsWith(ErrorCode::InvalidArgument, "1 to 8"));
  film_.array = {.views = 2, .baseline = 0};
  EXPECT_THAT(render_film(*take_, path, film_, nothing), FailsWith(ErrorCode::InvalidArgument, "positive"));
  film_.array = {.views = 2, .baseline = 0.06};
  film_.methods = {"linear", "floating"};
  EXPECT_THAT(render_film(*take_, path, film_, nothing), FailsWith(ErrorCode::InvalidArgument, "one method"));
}

TEST(SideBySide, NamesWhatItShowsWhereThereAreSeveral) {
  const Image grey(320, 240, 3, 128);
  EXPECT_EQ(side_by_side({grey}, {"linear"}).pixels, grey.pixels) << "one needs no name";
  const Image both = side_by_side({grey, grey}, {"linear", "floating"});
  ASSERT_EQ(both.width, 640);
  const auto brightest = [&](int from, int to) {
    int most = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = from; x < to; ++x) most = std::max<int>(most, both.at(x, y)[0]);
    return most;
  };
  EXPECT_GT(brightest(0, 60), 200) << "the left one's name";
  EXPECT_GT(brightest(320, 380), 200) << "the right one's";
  for (int y = 30; y < 240; ++y) ASSERT_EQ(both.at(100, y)[1], 128) << "below it the picture is as it was";
}

}  // namespace
}  // namespace floatstage::pipeline
