// The walk over a Matroska file's elements, on files made by hand.

#include "capture/matroska_index.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::IsEmpty;

std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int v : values) out += static_cast<char>(v);
  return out;
}

std::string element(const std::string& id, const std::string& content) {
  return id + bytes({0x40 | static_cast<int>(content.size() >> 8), static_cast<int>(content.size() & 0xFF)}) +
         content;
}

const std::string kEbml = bytes({0x1A, 0x45, 0xDF, 0xA3}), kSegment = bytes({0x18, 0x53, 0x80, 0x67}),
                  kCluster = bytes({0x1F, 0x43, 0xB6, 0x75}), kSimpleBlock = bytes({0xA3}),
                  kBlockGroup = bytes({0xA0}), kBlock = bytes({0xA1}), kReference = bytes({0xFB}),
                  kVoid = bytes({0xEC}), kTime = bytes({0xE7});
const std::string kUnknownSize = bytes({0x01, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF});

std::string block(int track, int flags, const std::string& picture) {
  return bytes({0x80 | track, 0, 0, flags}) + picture;
}

MatroskaIndex index_of(const std::string& content) {
  const TempFolder folder;
  const int fd = ::open(folder.write("a.mkv", content).c_str(), O_RDONLY);
  const Result<MatroskaIndex> index = index_matroska(fd);
  ::close(fd);
  EXPECT_THAT(index, IsOk());
  return index.value();
}

std::string picture_in(const std::string& file, const MatroskaIndex::Picture& picture) {
  return file.substr(static_cast<std::size_t>(picture.offset), static_cast<std::size_t>(picture.size));
}

TEST(MatroskaIndex, FindsPicturesInClustersAndGroups) {
  const std::string content =
      element(kEbml, "any") + kSegment + kUnknownSize + element(kVoid, std::string(700, '\xA3')) +
      element(kCluster, element(kTime, bytes({7})) + element(kSimpleBlock, block(1, 0x80, "first")) +
                            element(kSimpleBlock, block(1, 0x00, "second"))) +
      kCluster + kUnknownSize + element(kBlockGroup, element(kBlock, block(1, 0, "third"))) +
      element(kBlockGroup, element(kBlock, block(1, 0, "fourth")) + element(kReference, bytes({0x81})));
  const MatroskaIndex index = index_of(content);
  EXPECT_FALSE(index.cut);
  ASSERT_EQ(index.pictures.size(), 4u);
  const char* expected[] = {"first", "second", "third", "fourth"};
  const bool keyframes[] = {true, false, true, false};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(picture_in(content, index.pictures[i]), expected[i]);
    EXPECT_EQ(index.pictures[i].keyframe, keyframes[i]) << i;
  }
}

TEST(MatroskaIndex, LeavesOtherTracksAlone) {
  const MatroskaIndex index =
      index_of(element(kEbml, "") +
               element(kSegment, element(kCluster, element(kSimpleBlock, block(2, 0x80, "sound")))));
  EXPECT_THAT(index.pictures, IsEmpty());
  EXPECT_FALSE(index.cut);
}

TEST(MatroskaIndex, HasOnlyWholePicturesAtEveryLength) {
  const std::string one = element(kCluster, element(kSimpleBlock, block(1, 0x80, std::string(40, 'x'))));
  const std::string start = element(kEbml, "any") + kSegment + kUnknownSize,
                    content = start + one + one + one;
  for (std::size_t length = 0; length <= content.size(); ++length) {
    const MatroskaIndex index = index_of(content.substr(0, length));
    const std::size_t whole = length < start.size() ? 0 : (length - start.size()) / one.size();
    EXPECT_EQ(index.pictures.size(), whole) << length;
  }
}

TEST(MatroskaIndex, StopsAtWhatIsNoMatroska) {
  EXPECT_FALSE(index_of("").cut) << "an empty file ends nowhere in the middle";
  EXPECT_TRUE(index_of("RIFF....").cut);
  EXPECT_TRUE(index_of(std::string(100, '\0')).cut);
  EXPECT_TRUE(index_of(kCluster + kUnknownSize).cut) << "an EBML header comes first";
  EXPECT_TRUE(index_of(element(kEbml, "") + std::string(9, '\0')).cut);
  EXPECT_TRUE(index_of(element(kEbml, "") + element(kSimpleBlock, "")).cut) << "a block without its header";
  EXPECT_TRUE(index_of(element(kEbml, "") + element(kSimpleBlock, block(1, 0x02, "laced"))).cut);
  EXPECT_TRUE(
      index_of(element(kEbml, "") + kVoid + bytes({0x01, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFE})).cut);
}

TEST(MatroskaIndex, ReportsWhatTheSystemRefuses) {
  EXPECT_THAT(index_matroska(-1), FailsWith(ErrorCode::Io, "cannot read"));
}

}  // namespace
}  // namespace floatstage::capture
