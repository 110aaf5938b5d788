#include "studio/network/keys.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio::wire {
namespace {

namespace fs = std::filesystem;

StudioKeys some_keys() {
  const Result<StudioKeys> keys = make_keys();
  EXPECT_THAT(keys, IsOk());
  return *keys;
}

TEST(StudioKeys, AreOthersEachTime) { EXPECT_NE(some_keys().secret_key, some_keys().secret_key); }

TEST(StudioKeys, ComeBackFromAFileThatOnlyItsOwnerCanRead) {
  const TempFolder folder;
  const StudioKeys keys = some_keys();
  ASSERT_THAT(save_keys(keys, folder / "studio.keys"), IsOk());
  struct stat facts = {};
  ASSERT_EQ(::stat((folder / "studio.keys").c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777, 0600u);
  EXPECT_THAT(load_keys(folder / "studio.keys"), IsOkAnd(testing::Eq(keys)));
}

TEST(StudioKeys, AreNeverWrittenOver) {
  const TempFolder folder;
  const StudioKeys keys = some_keys();
  ASSERT_THAT(save_keys(keys, folder / "studio.keys"), IsOk());
  EXPECT_THAT(save_keys(some_keys(), folder / "studio.keys"),
              FailsWith(ErrorCode::AlreadyExists, "never written over"));
  EXPECT_THAT(load_keys(folder / "studio.keys"), IsOkAnd(testing::Eq(keys)));
}

TEST(StudioKeys, ThatOthersMayReadAreRefused) {
  const TempFolder folder;
  ASSERT_THAT(save_keys(some_keys(), folder / "studio.keys"), IsOk());
  fs::permissions(folder / "studio.keys", fs::perms::group_read, fs::perm_options::add);
  EXPECT_THAT(load_keys(folder / "studio.keys"),
              FailsWith(ErrorCode::InvalidArgument, "others may read these keys"));
}

TEST(StudioKeys, ThatDoNotBelongTogetherAreRefused) {
  const TempFolder folder;
  ASSERT_THAT(save_keys({some_keys().public_key, some_keys().secret_key}, folder / "mixed.keys"), IsOk());
  EXPECT_THAT(load_keys(folder / "mixed.keys"), FailsWith(ErrorCode::BadData, "mixed.keys: holds no keys"));
  EXPECT_THAT(load_keys(folder / "none.keys"), FailsWith(ErrorCode::NotFound, "none.keys"));
}

TEST(StudioKeys, CutOffAnywhereAreRefused) {
  const TempFolder folder;
  ASSERT_THAT(save_keys(some_keys(), folder / "studio.keys"), IsOk());
  const std::string whole = *read_file(folder / "studio.keys");
  for (std::size_t size = 0; size + 2 < whole.size(); size += 7) {
    const fs::path file = folder.write("cut.keys", std::string_view(whole).substr(0, size));
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_THAT(load_keys(file), FailsWith(ErrorCode::BadData, "holds no keys")) << size;
  }
}

TEST(Address, OfThisMachineNeedsNoKeys) {
  for (const char* address :
       {"tcp://127.0.0.1:5570", "tcp://127.0.0.9:0", "tcp://localhost:1", "tcp://[::1]:1"})
    EXPECT_THAT(check_address(address, {}), IsOk()) << address;
}

TEST(Address, ThatOthersReachNeedsKeysAndSaysSo) {
  for (const char* address :
       {"tcp://*:5570", "tcp://0.0.0.0:5570", "tcp://192.168.1.2:5570", "tcp://node1:5570"}) {
    EXPECT_THAT(check_address(address, {}), FailsWith(ErrorCode::InvalidArgument, "floatstage keys --out"))
        << address;
    EXPECT_THAT(check_address(address, some_keys()), IsOk()) << address;
  }
}

TEST(Address, OfAnotherMachineIsNotTakenForThisOneByItsFirstLetters) {
  for (const char* address : {"tcp://127.example:5570", "tcp://127.0.0.1.example.org:5570",
                              "tcp://localhost.example:1", "tcp://lo:5570", "tcp://[::]:1", "tcp://[::2]:1"})
    EXPECT_THAT(check_address(address, {}), FailsWith(ErrorCode::InvalidArgument, "leaves this machine"))
        << address;
}

TEST(Address, IsOneAddressAndNotSeveral) {
  for (const char* address : {"tcp://127.0.0.1:0;0.0.0.0:15570", "tcp://127.0.0.1:5570,tcp://0.0.0.0:5570",
                              "tcp://127.0.0.1;10.0.0.1:1", "tcp://127.0.0.1:5570/..",
                              "tcp://127.0.0.1:65536", "tcp://127.0.0.1:-1", "tcp://127.0.0.1: 1"})
    EXPECT_THAT(check_address(address, some_keys()),
                FailsWith(ErrorCode::InvalidArgument, "one host and one port"))
        << address;
}

TEST(Address, IsNamedWhenItIsNone) {
  for (const char* address : {"", "5570", "tcp://", "tcp://:5", "http://127.0.0.1:80", "tcp://127.0.0.1"})
    EXPECT_THAT(check_address(address, some_keys()), FailsWith(ErrorCode::InvalidArgument, "an address is"))
        << address;
}

}  // namespace
}  // namespace floatstage::studio::wire
