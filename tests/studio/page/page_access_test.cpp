#include "studio/page/page_access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::Pair;
using testing::UnorderedElementsAre;
using Verdict = PageAccess::Verdict;

constexpr const char* kToken = "0123456789abcdef0123";
const PageAccess::Clock::time_point kNow = PageAccess::Clock::time_point(std::chrono::hours(500'000));

PageRequest asked_at(const std::string& host) {
  PageRequest request;
  request.host = host;
  request.authorization = std::string("Bearer ") + kToken;
  return request;
}

TEST(PageAccess, IsForNamesThatAreTheStudiosOwn) {
  const PageAccess access(kToken, 8470, {"Stage.Example"});
  for (const char* host : {"127.0.0.1:8470", "192.168.3.4", "[::1]:8470", "[fe80::1]", "localhost:8470",
                           "LOCALHOST", "stage.example:8470"})
    EXPECT_EQ(access.judge(asked_at(host)), Verdict::Welcome) << host;
  for (const char* host :
       {"", "elsewhere.example", "localhost.example:8470", "127.0.0.1.example", "[", "[::1", ":"})
    EXPECT_EQ(access.judge(asked_at(host)), Verdict::OtherName) << host;
}

TEST(PageAccess, KnowsItsSessionsAndNoOthers) {
  const PageAccess access(kToken, 8470, {});
  const std::string session = access.new_session(kNow);
  const auto with = [](const std::string& cookies) {
    PageRequest request;
    request.host = "127.0.0.1";
    request.cookies = cookies;
    return request;
  };
  const std::string cookie = session.substr(0, session.find(';'));
  EXPECT_EQ(access.judge(with("other=1; " + cookie + "; more=2"), kNow), Verdict::Welcome);
  EXPECT_EQ(PageAccess(kToken, 8470, {}).judge(with(cookie), kNow), Verdict::Welcome)
      << "also after a restart";
  EXPECT_EQ(access.judge(with(cookie), kNow + PageAccess::kSession), Verdict::Stranger) << "it has ended";
  EXPECT_EQ(PageAccess("another-token-of-16", 8470, {}).judge(with(cookie), kNow), Verdict::Stranger);
  EXPECT_EQ(PageAccess(kToken, 8471, {}).judge(with(cookie), kNow), Verdict::Stranger) << "another node's";
  EXPECT_EQ(access.judge(with("floatstage_8470=9" + cookie.substr(cookie.find('=') + 1)), kNow),
            Verdict::Stranger)
      << "nobody else can lengthen it";
  for (const char* none :
       {"", "floatstage_8470", "floatstage_8470=", "floatstage_8470=-", "floatstage_8470=9-0"})
    EXPECT_EQ(access.judge(with(none), kNow), Verdict::Stranger) << none;
}

TEST(PageRequest, DecodesItsTarget) {
  PageRequest request;
  read_target("/api/a%2fb?label=one%20two+3&empty=&=x&label=later&bad=%4&worse=%zz&flag#part", request);
  EXPECT_EQ(request.path, "/api/a/b");
  EXPECT_THAT(request.query, UnorderedElementsAre(Pair("label", "one two 3"), Pair("empty", ""),
                                                  Pair("bad", "%4"), Pair("worse", "%zz"), Pair("flag", "")));
}

TEST(PageToken, IsRandomOrOfAFileThatIsOnesOwn) {
  const TempFolder folder;
  const auto secret = [&](const char* name, const char* bytes) {
    const std::filesystem::path file = folder.write(name, bytes);
    std::filesystem::permissions(file, std::filesystem::perms::owner_read);
    return file;
  };
  EXPECT_NE(*page_token({}), *page_token({}));
  EXPECT_EQ(page_token({})->size(), 32u);
  EXPECT_EQ(*page_token(secret("token", "abcdefgh-12345678_x\n")), "abcdefgh-12345678_x");
  EXPECT_THAT(page_token(secret("short", "abc\n")), FailsWith(ErrorCode::InvalidArgument, "short"));
  EXPECT_THAT(page_token(secret("odd", "abcdefgh 12345678\n")), FailsWith(ErrorCode::InvalidArgument, "odd"));
  EXPECT_THAT(page_token(folder / "none"), FailsWith(ErrorCode::NotFound, "none"));
  const std::filesystem::path open = secret("open", "abcdefgh-12345678_x\n");
  std::filesystem::permissions(open, std::filesystem::perms::others_read, std::filesystem::perm_options::add);
  EXPECT_THAT(page_token(open), FailsWith(ErrorCode::InvalidArgument, "others of this machine can read"));
}

}  // namespace
}  // namespace floatstage::studio
