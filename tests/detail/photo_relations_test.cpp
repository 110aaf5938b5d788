// Folders of made photographs: a wide one, closer ones, and what else lies in a folder.

#include "detail/photo_relations.h"

#include <atomic>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "detail/photo_graph.h"
#include "detail/relation_cache.h"
#include "tests/detail/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

using Eigen::Matrix3d;
using test::photograph;
using test::view_of_world;

class RelatedPhotographs : public testing::Test {
 protected:
  void save(const std::string& name, const Image& picture) { photos_.write(name, encode_jpeg(picture, 95)); }
  // A wide photograph, one twice as close and turned, and one of elsewhere.
  void save_three() {
    save("wide.jpg", photograph(480, 360, wide_));
    save("close.jpg", photograph(400, 300, close_));
    save("other.jpg", photograph(480, 360, wide_, 77));
  }
  Result<PhotoRelations> relate_them(const std::filesystem::path& cache = {}, int threads = 2,
                                     Watch watch = {}) {
    return relate_photos(photos_.path(), {cache, threads, std::move(watch)});
  }
  TempFolder photos_, other_;
  const Matrix3d wide_ = view_of_world(0, 0, 2), close_ = view_of_world(320, 150, 1, 0.3);
};

TEST_F(RelatedPhotographs, AreContainedWhereTheyShowAPart) {
  save_three();
  const Result<PhotoRelations> r = relate_them();
  ASSERT_THAT(r, IsOk());
  const PairRelation& pair = r->pair(0, 2);  // close.jpg, other.jpg, wide.jpg
  ASSERT_TRUE(pair.contained()) << pair.why;
  EXPECT_NEAR(pair.zoom, 2, 0.01);
  const Matrix3d truth = wide_.inverse() * close_;
  for (const Eigen::Vector3d& corner : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(400, 300, 1)})
    EXPECT_LT(((pair.parent_from_child * corner).hnormalized() - (truth * corner).hnormalized()).norm(), 0.5);
  EXPECT_FALSE(r->pair(2, 0).contained());
  for (const std::size_t scene : {0u, 2u}) {
    EXPECT_FALSE(r->pair(scene, 1).contained());
    EXPECT_FALSE(r->pair(1, scene).contained());
  }
}

TEST_F(RelatedPhotographs, AreTheSameWhateverTheThreadsAndTheCache) {
  save_three();
  const Result<PhotoRelations> one = relate_them({}, 1), two = relate_them(other_ / "cache", 2),
                               cached = relate_them(other_ / "cache", 2);
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(cached, IsOk());
  EXPECT_EQ(one->matched, 3u);
  EXPECT_EQ(cached->matched, 0u);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(one->pairs[i].parent_from_child, two->pairs[i].parent_from_child);
    EXPECT_EQ(one->pairs[i].parent_from_child, cached->pairs[i].parent_from_child);
    EXPECT_EQ(one->pairs[i].why, cached->pairs[i].why);
    EXPECT_EQ(one->pairs[i].inliers, cached->pairs[i].inliers);
  }
}

TEST_F(RelatedPhotographs, CostOneMoreRowForOneMorePhotograph) {
  save_three();
  ASSERT_THAT(relate_them(other_ / "cache"), IsOk());
  save("closer.jpg", photograph(400, 300, view_of_world(400, 260, 0.5)));
  const Result<PhotoRelations> r = relate_them(other_ / "cache");
  ASSERT_THAT(r, IsOk());
  EXPECT_EQ(r->matched, 3u) << "with each of the three that were there";
  EXPECT_EQ(choose_parents(*r, "")->photos[1].parent, 0) << "closer.jpg lies in close.jpg";
}

TEST_F(RelatedPhotographs, AreRelatedAgainWhenAFileChangesOrTheCacheIsDamaged) {
  save_three();
  ASSERT_THAT(relate_them(other_ / "cache"), IsOk());
  save("other.jpg", photograph(480, 360, wide_, 78));
  EXPECT_EQ(relate_them(other_ / "cache")->matched, 2u);
  for (const auto& file : std::filesystem::directory_iterator(other_ / "cache")) {
    std::string bytes = *read_file(file.path());
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x21);
    if (file.path().extension() == ".json") bytes.resize(bytes.size() / 2);
    ASSERT_THAT(write_file(file.path(), bytes), IsOk());
  }
  const Result<PhotoRelations> r = relate_them(other_ / "cache");
  ASSERT_THAT(r, IsOk());
  EXPECT_EQ(r->matched, 3u);
  EXPECT_TRUE(r->pair(0, 2).contained());
}

TEST_F(RelatedPhotographs, ThatAreInterruptedGoOnWhereTheyWere) {
  save_three();
  std::atomic<int> asked = 0;
  Watch watch;
  watch.cancelled = [&] { return ++asked > 5; };  // three features, one look, one pair
  EXPECT_THAT(relate_them(other_ / "cache", 1, watch),
              FailsWith(ErrorCode::Cancelled, "what was found so far"));
  EXPECT_EQ(relate_them(other_ / "cache")->matched, 2u);
  EXPECT_THAT(relate_them({}, 1, {{}, {}, {}, [] { return true; }}),
              FailsWith(ErrorCode::Cancelled, "nothing"));
}

TEST_F(RelatedPhotographs, MayLieBesideFilesThatAreNone) {
  save_three();
  photos_.write("cut.jpg", encode_jpeg(photograph(100, 80, wide_), 90).substr(0, 900));
  photos_.write("notes.txt", "hello");
  std::filesystem::create_directories(photos_ / ".thumbnails");
  photos_.write(".thumbnails/a.jpg", "x");
  std::filesystem::create_directories(photos_ / "more");
  save("more/sky.jpg", Image(300, 200, 3, 200));
  ASSERT_THAT(save_png(Image(1, 1, 3, 9), photos_ / "pixel.png"), IsOk());
  save("copy.jpg", photograph(400, 300, close_));
  const Result<PhotoRelations> r = relate_them();
  ASSERT_THAT(r, IsOk());
  ASSERT_EQ(r->unread.size(), 1u);
  EXPECT_THAT(r->unread[0].why, testing::HasSubstr("cut.jpg"));
  std::vector<std::string> names;
  for (const Photo& photo : r->photos) names.push_back(photo.name);
  EXPECT_THAT(names, testing::ElementsAre("close.jpg", "copy.jpg", "more/sky.jpg", "other.jpg", "pixel.png",
                                          "wide.jpg"));
  EXPECT_THAT(r->pair(2, 5).why, testing::HasSubstr("0 features agree")) << "all sky";
  EXPECT_THAT(r->pair(4, 5).why, testing::HasSubstr("0 features agree")) << "one pixel";
  const Result<PhotoGraph> graph = choose_parents(*r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_EQ(graph->photos[0].parent, 5);
  EXPECT_EQ(graph->photos[1].parent, -1) << "of two copies one is enough";
}

TEST_F(RelatedPhotographs, NeedAFolderWithAtLeastOneThatCanBeRead) {
  EXPECT_THAT(relate_photos(photos_ / "none", {}), FailsWith(ErrorCode::NotFound, "none is no folder"));
  EXPECT_THAT(relate_them(), FailsWith(ErrorCode::NotFound, "has no photographs"));
  photos_.write("empty.jpg", "");
  EXPECT_THAT(relate_them(), FailsWith(ErrorCode::BadData, "empty.jpg is empty"));
}

TEST(FeatureFile, GivesBackWhatItKeptAndNothingWhenAnythingIsAmiss) {
  const PhotoFeatures features = find_features(photograph(200, 150, view_of_world(0, 0, 1)));
  ASSERT_GT(features.count(), 20);
  const std::string bytes = features_to_bytes(features);
  const std::optional<PhotoFeatures> back = features_from_bytes(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->points, features.points);
  EXPECT_EQ(back->descriptors, features.descriptors);
  EXPECT_EQ(back->width, 200);
  for (std::size_t cut = 0; cut < bytes.size(); cut += 97)
    EXPECT_FALSE(features_from_bytes(bytes.substr(0, cut)));
  for (std::size_t at = 0; at < bytes.size(); at += 101) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_FALSE(features_from_bytes(changed)) << at;
  }
}

}  // namespace
}  // namespace floatstage::detail
