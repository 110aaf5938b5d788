#include "pipeline/film_file.h"

#include <cmath>

#include <ImfRgbaFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/orbit.h"
#include "pipeline/process/process.h"
#include "pipeline/subject.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// Ends the job once so many pictures were drawn.
class Impatient final : public Progress {
 public:
  explicit Impatient(int pictures) : left_(pictures) {}
  void begin(const std::string&, std::size_t) override {}
  void advance(std::size_t) override { --left_; }
  void end() override {}
  bool cancelled() const override { return left_ <= 0; }

 private:
  int left_;
};

class AFilmFile : public testing::Test {
 protected:
  static constexpr int kPart = 5, kPictures = 13;  // parts of 5 and 8

  void SetUp() override {
    path_ = small_take(folder_, 3);
    ASSERT_THAT(process_take({.take = path_, .matte = "chroma", .hull = recon::HullOptions{}}), IsOk());
    film_.width = 48;
    film_.height = 36;
    film_.frame_rate = 25;
    film_.seconds = kPictures / 25.0;
    film_.frames = {0, 1, 2};
    film_.methods = {"nearest"};
    film_.renderer.back_end = render::BackEnd::Cpu;
  }
  Result<FilmFileReport> render(const fs::path& out, std::vector<int> pictures = {}) {
    auto take = std::move(*capture::TakeReader::open(path_));
    const CameraPath path = orbit_around(take->rig(), *find_subject(*take), {.seconds = 5}).path;
    return render_film_file(*take, path, film_,
                            {.out = out,
                             .drawn_by = "cpu",
                             .with_opacity = with_opacity_,
                             .stills = stills_,
                             .pictures = std::move(pictures),
                             .part_pictures = kPart});
  }
  // What a run leaves that is stopped after so many pictures.
  void stop_after(int pictures, const fs::path& out) {
    Impatient user(pictures);
    film_.progress = &user;
    EXPECT_THAT(render(out), FailsWith(ErrorCode::Cancelled, "goes on from there"));
    film_.progress = nullptr;
  }
  fs::path out(const std::string& name) const { return folder_ / name; }

  TempFolder folder_;
  fs::path path_;
  FilmOptions film_;
  bool with_opacity_ = false;
  Stills stills_ = Stills::Png;
};

TEST_F(AFilmFile, StoppedAndGoneOnWithHasTheBytesOfOneThatWasNot) {
  const Result<FilmFileReport> whole = render(out("whole.mp4"));
  ASSERT_THAT(whole, IsOk());
  EXPECT_EQ(whole->parts, 2);
  EXPECT_EQ(whole->film.pictures, kPictures);
  stop_after(7, out("film.mp4"));
  EXPECT_FALSE(fs::exists(out("film.mp4")));
  const Result<FilmFileReport> rest = render(out("film.mp4"));
  ASSERT_THAT(rest, IsOk());
  EXPECT_EQ(rest->kept, kPart);
  EXPECT_EQ(rest->film.pictures, kPictures - kPart);
  EXPECT_EQ(*read_file(out("film.mp4")), *read_file(out("whole.mp4")));
  EXPECT_FALSE(fs::exists(out("film.mp4.parts")));
}

TEST_F(AFilmFile, HasEveryPictureOfAnUnbrokenOneAtItsTime) {
  stop_after(6, out("film.mp4"));
  ASSERT_THAT(render(out("film.mp4")), IsOk());
  ASSERT_THAT(render(out("pngs")), IsOk());
  auto reader = capture::MediaReader::open(out("film.mp4"));
  ASSERT_THAT(reader, IsOk());
  EXPECT_DOUBLE_EQ((*reader)->frame_rate(), 25);
  std::vector<Image> before;
  for (int i = 0; i < kPictures; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "%06d.png", i);
    const Result<Image> shown = (*reader)->next(), drawn = load_png(out("pngs") / name);
    ASSERT_THAT(shown, IsOk()) << i;
    EXPECT_THAT(*shown, ImageNear(*drawn, 30.0)) << i << ": the picture itself, coded";
    if (i >= 3) {
      EXPECT_GT(psnr(*shown, *drawn), psnr(*shown, before[static_cast<std::size_t>(i - 3)]))
          << i << ": not another one";
    }
    before.push_back(*drawn);
  }
  EXPECT_THAT((*reader)->next(), FailsWith(ErrorCode::EndOfStream, ""));
}

TEST_F(AFilmFile, OfPngsGoesOnToo) {
  ASSERT_THAT(render(out("whole")), IsOk());
  stop_after(7, out("film"));
  ASSERT_THAT(render(out("film")), IsOk());
  int pictures = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(out("whole"))) {
    EXPECT_EQ(*read_file(entry.path()), *read_file(out("film") / entry.path().filename()));
    ++pictures;
  }
  EXPECT_EQ(pictures, kPictures);
  EXPECT_FALSE(fs::exists(out("film.parts")));
}

// What another program that knows the format makes of an EXR: straight 8-bit sRGB.
Image decoded_exr(const fs::path& file) {
  Imf::RgbaInputFile in(file.c_str());
  const Imath::Box2i box = in.dataWindow();
  Image image(box.max.x + 1, box.max.y + 1, 4);
  std::vector<Imf::Rgba> pixels(image.pixels.size() / 4);
  in.setFrameBuffer(pixels.data(), 1, static_cast<std::size_t>(image.width));
  in.readPixels(0, image.height - 1);
  const auto coded = [](float linear) {
    return static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(linear <= 0.0031308f ? 12.92f * linear
                                                          : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f,
                                     0.0f, 1.0f)));
  };
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const float a = pixels[p].a, undo = a > 0 ? 1 / a : 0;
    image.pixels[4 * p] = coded(undo * pixels[p].r);
    image.pixels[4 * p + 1] = coded(undo * pixels[p].g);
    image.pixels[4 * p + 2] = coded(undo * pixels[p].b);
    image.pixels[4 * p + 3] = static_cast<std::uint8_t>(std::lround(255 * a));
  }
  return image;
}

TEST_F(AFilmFile, OfExrsHoldsThePicturesInLinearLightMultipliedByTheirOpacity) {
  with_opacity_ = true;
  ASSERT_THAT(render(out("pngs")), IsOk());
  stills_ = Stills::Exr;
  stop_after(7, out("exrs"));
  const Result<FilmFileReport> rest = render(out("exrs"));
  ASSERT_THAT(rest, IsOk());
  EXPECT_EQ(rest->kept, kPart);
  long soft = 0;
  for (int i = 0; i < kPictures; ++i) {
    const std::string number = text("0000", i < 10 ? "0" : "", i);
    const Image png = *load_png(out("pngs") / (number + ".png")),
                exr = decoded_exr(out("exrs") / (number + ".exr"));
    ASSERT_EQ(exr.pixels.size(), png.pixels.size());
    for (std::size_t p = 0; p < png.pixels.size(); p += 4) {
      ASSERT_EQ(exr.pixels[p + 3], png.pixels[p + 3]);
      soft += png.pixels[p + 3] > 0 && png.pixels[p + 3] < 255;
      for (std::size_t c = 0; c < 3 && png.pixels[p + 3] > 0; ++c)
        ASSERT_NEAR(exr.pixels[p + c], png.pixels[p + c], 1) << "opacity " << int{png.pixels[p + 3]};
    }
  }
  EXPECT_GT(soft, 0) << "outlines are soft: multiplying shows there";
  EXPECT_THAT(render(out("film.mov")), FailsWith(ErrorCode::InvalidArgument, "EXRs are stills"));
}

TEST_F(AFilmFile, IsMadeByRunsWithPicturesOfTheirOwn) {
  ASSERT_THAT(render(out("whole.mp4")), IsOk());
  const Result<FilmFileReport> later = render(out("film.mp4"), {12});
  ASSERT_THAT(later, IsOk());
  EXPECT_EQ(later->film.pictures, kPictures - kPart) << "parts are made whole";
  EXPECT_EQ(later->done, 1);
  EXPECT_FALSE(fs::exists(out("film.mp4"))) << "who makes a part joins nothing";
  ASSERT_THAT(render(out("film.mp4"), {0, 1}), IsOk());
  const Result<FilmFileReport> joined = render(out("film.mp4"));
  ASSERT_THAT(joined, IsOk());
  EXPECT_EQ(joined->kept, kPictures);
  EXPECT_EQ(joined->film.pictures, 0);
  EXPECT_EQ(*read_file(out("film.mp4")), *read_file(out("whole.mp4")));
  EXPECT_THAT(render(out("other.mp4"), {13}), FailsWith(ErrorCode::InvalidArgument, "picture 13"));
}

TEST_F(AFilmFile, WithOpacityGoesOnToo) {
  with_opacity_ = true;
  ASSERT_THAT(render(out("whole.mov")), IsOk());
  stop_after(7, out("film.mov"));
  const Result<FilmFileReport> rest = render(out("film.mov"));
  ASSERT_THAT(rest, IsOk());
  EXPECT_EQ(rest->kept, kPart);
  EXPECT_EQ(*read_file(out("film.mov")), *read_file(out("whole.mov")));
  EXPECT_THAT(render(out("film.mp4")), FailsWith(ErrorCode::InvalidArgument, "holds no opacity"));
}

TEST_F(AFilmFile, KeepsNoPartThatOtherOptionsMade) {
  stop_after(7, out("film.mp4"));
  film_.renderer.background = {1, 0, 0};
  EXPECT_THAT(render(out("film.mp4"), {0}), FailsWith(ErrorCode::AlreadyExists, "parts of another film"));
  const Result<FilmFileReport> again = render(out("film.mp4"));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->kept, 0);
}

TEST_F(AFilmFile, DrawsAPartAgainWhoseMeshOrMatteHasChanged) {
  stop_after(7, out("film.mp4"));
  const TakeLayout layout(path_);
  ASSERT_TRUE(fs::remove(layout.matte("cam00", 1)));
  const Result<FilmFileReport> again = render(out("film.mp4"));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->kept, 0);
}

TEST_F(AFilmFile, DrawsAPartAgainThatIsDamaged) {
  stop_after(7, out("film.mp4"));
  ASSERT_THAT(write_file(out("film.mp4.parts") / "000000.mp4", "cut"), IsOk());
  const Result<FilmFileReport> again = render(out("film.mp4"));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->kept, 0);
}

TEST_F(AFilmFile, OfPngsDrawsAPartAgainOneOfWhosePicturesIsDamaged) {
  stop_after(7, out("film"));
  ASSERT_THAT(write_file(out("film.parts") / "pictures" / "000004.png", "cut"), IsOk());
  const Result<FilmFileReport> again = render(out("film"));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->kept, 0);
}

TEST_F(AFilmFile, LeavesNothingWhenItIsStoppedBeforeTheFirstPart) {
  stop_after(3, out("film.mp4"));
  stop_after(3, out("film"));
  EXPECT_THAT(folder_.names(), testing::UnorderedElementsAre("take"));
}

TEST_F(AFilmFile, WithMotionBlurIsOnePart) {
  film_.methods = {"filtered"};
  film_.seconds = 11 / 25.0;
  film_.renderer.motion_blur = 0.5;
  const Result<FilmFileReport> whole = render(out("film.mp4"));
  ASSERT_THAT(whole, IsOk());
  EXPECT_EQ(whole->parts, 1);
}

// A walk around one instant: a picture's fields know those before it.
TEST_F(AFilmFile, WithFieldMemoryHasTheSameBytesWhoeverMakesItsPartsAndWhen) {
  film_.methods = {"floating"};
  film_.frames = {1};
  ASSERT_THAT(render(out("forgetful.mp4")), IsOk());
  film_.renderer.field_memory = 0.75;
  ASSERT_THAT(render(out("whole.mp4")), IsOk());
  EXPECT_NE(*read_file(out("whole.mp4")), *read_file(out("forgetful.mp4"))) << "nothing is tested";
  stop_after(7, out("film.mp4"));
  ASSERT_THAT(render(out("film.mp4")), IsOk());
  EXPECT_EQ(*read_file(out("film.mp4")), *read_file(out("whole.mp4")));
  for (const int picture : {7, 2}) ASSERT_THAT(render(out("shared.mp4"), {picture}), IsOk());  // by others
  ASSERT_THAT(render(out("shared.mp4")), IsOk());
  EXPECT_EQ(*read_file(out("shared.mp4")), *read_file(out("whole.mp4")));
}

TEST_F(AFilmFile, WithFieldMemoryShowsNothingOfItsBlocks) {
  auto take = std::move(*capture::TakeReader::open(path_));
  const CameraPath path = orbit_around(take->rig(), *find_subject(*take), {.seconds = 5}).path;
  film_.methods = {"floating", "nearest"};
  film_.frames = {1};
  const auto drawn = [&](double memory, int block) {
    film_.renderer.field_memory = memory;
    film_.block = block;
    std::vector<Image> pictures;
    EXPECT_THAT(render_film(*take, path, film_,
                            [&](FilmPicture picture) {
                              pictures.push_back(picture.renders.front());
                              return Result<void>();
                            }),
                IsOk());
    return pictures;
  };
  const std::vector<Image> alone = drawn(0, 50), in_blocks = drawn(0.75, 4), in_one = drawn(0.75, 50);
  ASSERT_EQ(in_blocks.size(), std::size_t(kPictures));
  ASSERT_EQ(in_one.size(), std::size_t(kPictures));
  for (const std::size_t first : {8, 12}) {
    EXPECT_NE(in_one[first], alone[first]) << "nothing is tested";
    EXPECT_GT(psnr(in_blocks[first], in_one[first]), psnr(alone[first], in_one[first])) << first;
  }
}

}  // namespace
}  // namespace floatstage::pipeline
