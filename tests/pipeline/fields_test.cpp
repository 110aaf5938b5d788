// Fields beside a take: process --fields, and films that draw with them.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/mesh_io.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/field_file.h"
#include "pipeline/film.h"
#include "pipeline/orbit.h"
#include "pipeline/process/process.h"
#include "pipeline/scene_loader.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

FieldFile example() {
  FieldFile file;
  file.flow.shrink = 2;
  file.mesh = std::string(32, 'a');
  file.camera = std::string(32, 'b');
  file.place = {100, 101, 3.5F, -2};
  file.width = 3;
  file.height = 2;
  file.neighbors = {{"cam01", std::string(32, 'c'), {1, -2, 3, -4, 5, -6, 7, -8, 9, -10, 11, -12}},
                    {"cam02", std::string(32, 'd'), std::vector<std::int16_t>(12, 32767)}};
  return file;
}

TEST(FieldFiles, AreReadAsTheyWereWritten) {
  const Result<FieldFile> read = decode_fields(encode_fields(example()), "a.fields");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(*read, example());
}

TEST(FieldFiles, ThatAreCutOffAnywhereAreRefused) {
  const std::string bytes = encode_fields(example());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    ASSERT_THAT(decode_fields(bytes.substr(0, size), "a.fields"), FailsWith(ErrorCode::BadData, "a.fields"))
        << size;
  EXPECT_THAT(decode_fields(bytes + "x", "a.fields"), FailsWith(ErrorCode::BadData, "process --fields"));
}

TEST(FieldFiles, WithAnyByteChangedAreRefused) {
  const std::string bytes = encode_fields(example());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    ASSERT_THAT(decode_fields(damaged, "a.fields"), FailsWith(ErrorCode::BadData, "a.fields")) << at;
  }
}

TEST(FieldFiles, WithSizesThatNoFieldHasAreRefused) {
  for (const auto& [width, height] :
       {std::pair(-3, 2), std::pair(1, 12), std::pair(4096, 2), std::pair(0, 2)}) {
    FieldFile file = example();
    file.width = width;
    file.height = height;
    EXPECT_THAT(decode_fields(encode_fields(file), "a.fields"), FailsWith(ErrorCode::BadData, "head"));
  }
}

class TakeWithFields : public testing::Test {
 protected:
  void SetUp() override {
    path_ = small_take(folder_, 1);
    ASSERT_THAT(process(), IsOk());
  }
  Result<ProcessReport> process(bool redo = false) {
    ProcessOptions options{.take = path_, .matte = "chroma", .hull = recon::HullOptions{}};
    options.hull->resolution = 48;
    options.fields = true;
    options.redo = redo;
    return process_take(options);
  }
  fs::path file(const std::string& serial) const { return field_path(TakeLayout(path_), serial, 0); }
  std::string bytes(const std::string& serial) const {
    const Result<std::string> read = read_file(file(serial));
    EXPECT_THAT(read, IsOk());
    return read ? *read : std::string();
  }
  // Two pictures of an orbit.
  Result<std::vector<Image>> film() {
    auto take = capture::TakeReader::open(path_);
    if (!take) return forward(take);
    const Result<Subject> subject = find_subject(**take);
    if (!subject) return forward(subject);
    OrbitOptions walk;
    walk.seconds = 1;
    FilmOptions options;
    options.width = 96;
    options.height = 72;
    options.seconds = 1;
    options.frame_rate = 2;
    options.frames = {0};
    options.methods = {kFieldMethod};
    options.renderer.back_end = render::BackEnd::Cpu;
    std::vector<Image> pictures;
    const Result<FilmReport> drawn = render_film(**take, orbit_around((*take)->rig(), *subject, walk).path,
                                                 options, [&](FilmPicture picture) -> Result<void> {
                                                   pictures.push_back(picture.renders.front());
                                                   return {};
                                                 });
    if (!drawn) return forward(drawn);
    return pictures;
  }
  TempFolder folder_;
  fs::path path_;
};

TEST_F(TakeWithFields, HasAFileForEachCameraToItsNearest) {
  const auto take = std::move(*capture::TakeReader::open(path_));
  for (const RigCamera& camera : take->rig().cameras) {
    const Result<FieldFile> fields = load_field_file(file(camera.serial));
    ASSERT_THAT(fields, IsOk());
    EXPECT_EQ(fields->neighbors.size(), 4U) << camera.serial;
    EXPECT_GE(fields->width, 16);
  }
}

TEST_F(TakeWithFields, MakesOnlyWhatIsMissingAndTheSameAgain) {
  const std::string before = bytes("cam02");
  fs::remove(file("cam02"));
  const Result<ProcessReport> again = process();
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->fields->made, 1);
  EXPECT_EQ(again->fields->kept, 5);
  EXPECT_EQ(bytes("cam02"), before);
  const Result<ProcessReport> redone = process(true);
  ASSERT_THAT(redone, IsOk());
  EXPECT_EQ(redone->fields->made, 6);
}

TEST_F(TakeWithFields, MakesAnewWhatWasCutOff) {
  const std::string before = bytes("cam02");
  ASSERT_THAT(write_file(file("cam02"), before.substr(0, before.size() / 2)), IsOk());
  EXPECT_THAT(film(), FailsWith(ErrorCode::BadData, "cut off"));
  const Result<ProcessReport> again = process();
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->fields->made, 1);
  EXPECT_EQ(bytes("cam02"), before);
}

TEST_F(TakeWithFields, IsDrawnAsWithoutThem) {
  const auto with = film();
  ASSERT_THAT(with, IsOk());
  fs::remove_all(field_folder(TakeLayout(path_)));
  const auto without = film();
  ASSERT_THAT(without, IsOk());
  EXPECT_EQ(*with, *without);
}

TEST_F(TakeWithFields, IsNotDrawnWithThoseOfAnotherMesh) {
  Result<Mesh> mesh = load_ply(TakeLayout(path_).mesh(0));
  ASSERT_THAT(mesh, IsOk());
  for (Eigen::Vector3f& p : mesh->positions) p.z() += 0.02F;
  ASSERT_THAT(save_ply(*mesh, TakeLayout(path_).mesh(0)), IsOk());
  const auto stale = film();
  ASSERT_THAT(stale, IsOk());
  // It says so:
  const auto take = std::move(*capture::TakeReader::open(path_));
  const SceneFrame scene = *SceneLoader(*take, true).load(0);
  render::Scene drawn;
  ASSERT_THAT(drawn.set(*rig_with_colors(*take), scene), IsOk());
  std::optional<std::string> sentence;
  const auto fields = load_fields(take->layout(), take->rig(), 0, drawn, &sentence);
  ASSERT_THAT(fields, IsOk());
  EXPECT_EQ(*fields, nullptr);
  ASSERT_TRUE(sentence);
  EXPECT_THAT(*sentence, testing::AllOf(testing::HasSubstr("another mesh"), testing::HasSubstr("--fields")));
  // And draws without them; whoever wants them makes them anew.
  fs::remove_all(field_folder(TakeLayout(path_)));
  const auto without = film();
  ASSERT_THAT(without, IsOk());
  EXPECT_EQ(*stale, *without);
}

TEST_F(TakeWithFields, AreReadForSomePhotographsAlone) {
  const auto take = std::move(*capture::TakeReader::open(path_));
  const SceneFrame scene = *SceneLoader(*take, true).load(0);
  render::Scene drawn;
  ASSERT_THAT(drawn.set(*rig_with_colors(*take), scene, {true, true, false, true, false, false}), IsOk());
  std::optional<std::string> sentence;
  const auto fields = load_fields(take->layout(), take->rig(), 0, drawn, &sentence);
  ASSERT_THAT(fields, IsOk());
  ASSERT_NE(*fields, nullptr);
  for (const auto& [pair, field] : (*fields)->fields) {
    EXPECT_THAT(pair.from, testing::AnyOf(0, 1, 3));
    EXPECT_THAT(pair.to, testing::AnyOf(0, 1, 3));
  }
  EXPECT_FALSE(sentence) << *sentence;
}

class StopsAfter : public Progress {
 public:
  explicit StopsAfter(int items) : left_(items) {}
  void begin(const std::string& what, std::size_t) override { counts_ = what == "fields"; }
  void advance(std::size_t) override { left_ -= counts_; }
  void end() override {}
  bool cancelled() const override { return left_ <= 0; }

 private:
  int left_;
  bool counts_ = false;
};

TEST_F(TakeWithFields, GoesOnWhereItWasStopped) {
  const std::string before = bytes("cam05");
  fs::remove_all(field_folder(TakeLayout(path_)));
  StopsAfter two(2);
  ProcessOptions options{.take = path_, .fields = true, .progress = &two};
  EXPECT_THAT(process_take(options), FailsWith(ErrorCode::Cancelled, ""));
  int there = 0;
  for (const auto& entry : fs::recursive_directory_iterator(field_folder(TakeLayout(path_))))
    there += entry.is_regular_file();
  EXPECT_EQ(there, 2);
  const Result<ProcessReport> rest = process();
  ASSERT_THAT(rest, IsOk());
  EXPECT_EQ(rest->fields->kept, 2);
  EXPECT_EQ(rest->fields->made, 4);
  EXPECT_EQ(bytes("cam05"), before);
}

}  // namespace
}  // namespace floatstage::pipeline
