#include "pipeline/calibrate/same_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SamePictures : public testing::Test {
 protected:
  // A camera with pictures of the given contents.
  CameraFiles camera(const std::string& serial, const std::vector<std::string>& contents) {
    CameraFiles out{serial, {}};
    for (std::size_t i = 0; i < contents.size(); ++i) {
      const std::string name = text(serial, "_", i, ".png");
      folder_.write(name, contents[i]);
      out.files.push_back(folder_ / name);
    }
    return out;
  }
  TempFolder folder_;
};

TEST_F(SamePictures, AreNotedOfNoSoundSession) {
  const auto remarks = notice_same_pictures({camera("left", {"a1", "a2"}), camera("right", {"b1", "b2"})});
  ASSERT_THAT(remarks, IsOk());
  EXPECT_THAT(*remarks, IsEmpty());
}

TEST_F(SamePictures, GivenToTwoCamerasAsOneFolderNameBoth) {
  const CameraFiles left = camera("left", {"a1", "a2"});
  EXPECT_THAT(notice_same_pictures({left, {"right", left.files}}),
              FailsWith(ErrorCode::InvalidArgument, "cameras 'left' and 'right' were both given"));
}

TEST_F(SamePictures, CopiedToAnotherNameNameBothCamerasAndThePictures) {
  const auto result =
      notice_same_pictures({camera("left", {"a1", "a2", "a3"}), camera("right", {"a1", "a2", "b3"})});
  EXPECT_THAT(result,
              FailsWith(ErrorCode::InvalidArgument, "have 2 pictures that are the same byte for byte"));
  EXPECT_THAT(result, FailsWith(ErrorCode::InvalidArgument, "left_0.png"));
}

TEST_F(SamePictures, FewOfManyAreARemark) {
  const auto remarks = notice_same_pictures(
      {camera("left", {"x1", "a2", "a3", "a4"}), camera("right", {"x1", "b2", "b3", "b4"})});
  ASSERT_THAT(remarks, IsOk());
  EXPECT_THAT(*remarks, ElementsAre(HasSubstr("'left' and 'right' have 1 picture that")));
}

TEST_F(SamePictures, TwiceInOneCameraAreARemark) {
  const auto remarks =
      notice_same_pictures({camera("left", {"a1", "a1", "a3"}), camera("right", {"b1", "b2", "b3"})});
  ASSERT_THAT(remarks, IsOk());
  EXPECT_THAT(*remarks, ElementsAre(HasSubstr("camera 'left' was given 1 picture more than once")));
}

}  // namespace
}  // namespace floatstage::pipeline
