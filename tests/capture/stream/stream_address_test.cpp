#include "capture/stream/stream_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

using testing::HasSubstr;
using testing::Not;
using Kind = StreamAddress::Kind;

StreamAddress parsed(const std::string& url) {
  const Result<StreamAddress> address = parse_stream_address(url);
  EXPECT_THAT(address, IsOk()) << url;
  return address ? *address : StreamAddress();
}

TEST(StreamAddress, KnowsWhoCallsWhom) {
  EXPECT_TRUE(parsed("srt://127.0.0.1:9000?mode=listener").listens);
  EXPECT_FALSE(parsed("srt://127.0.0.1:9000").listens);
  EXPECT_EQ(parsed("srt://:9000?latency=20000&mode=listener").port, 9000);
  EXPECT_EQ(parsed("udp://[::1]:9000?pkt_size=1316").host, "::1");
  EXPECT_EQ(parsed("rtsp://127.0.0.1/stage").port, 554);
  EXPECT_EQ(parsed("v4l2:/dev/video7").path, "/dev/video7");
  EXPECT_EQ(parsed("file:a b.ts").path, "a b.ts");
}

TEST(StreamAddress, SaysWhatIsWrong) {
  for (const auto& [url, what] : std::vector<std::pair<const char*, const char*>>{
           {"", "no such kind"},
           {"srt", "no such kind"},
           {"http://127.0.0.1:80", "no such kind"},
           {"srt://127.0.0.1", "needs a port"},
           {"srt://127.0.0.1:0", "needs a port"},
           {"udp://127.0.0.1:65536", "needs a port"},
           {"udp://127.0.0.1:12x", "needs a port"},
           {"srt://[::1]", "needs a port"},
           {"srt://:9000", "?mode=listener"},
           {"udp://:9000", "names no host"},
           {"srt://127.0.0.1:9000?mode=listen", "listener (players call)"},
           {"srt://127.0.0.1:9000?mood=listener", "no option 'mood'"},
           {"srt://127.0.0.1:9000?passphrase=short", "10 to 79"},
           {"file:", "names no path"},
           {"v4l2:", "names no path"}})
    EXPECT_THAT(parse_stream_address(url), FailsWith(ErrorCode::InvalidArgument, what)) << url;
}

TEST(StreamAddress, KeepsSecretsToItself) {
  const StreamAddress srt = parsed("srt://:9000?passphrase=0123456789ab&mode=listener");
  EXPECT_TRUE(srt.encrypted);
  EXPECT_THAT(srt.shown, Not(HasSubstr("0123456789ab")));
  EXPECT_THAT(srt.shown, HasSubstr("mode=listener"));
  EXPECT_THAT(parsed("rtsp://me:secret@127.0.0.1:8554/x").shown, Not(HasSubstr("secret")));
  EXPECT_EQ(parsed("rtsp://me:secret@127.0.0.1:8554/x").host, "127.0.0.1");
  EXPECT_THAT(parse_stream_address("srt://127.0.0.1:9000?passphrase=hush").error().message,
              Not(HasSubstr("hush")));
}

TEST(StreamAddress, KnowsWhatLeavesThisMachine) {
  const auto stays = [](const char* url) { return is_loopback(parsed(url)); };
  EXPECT_THAT(stays("udp://127.0.0.1:9000"), IsOkAnd(true));
  EXPECT_THAT(stays("udp://127.8.8.8:9000"), IsOkAnd(true));
  EXPECT_THAT(stays("srt://[::1]:9000"), IsOkAnd(true));
  EXPECT_THAT(stays("udp://192.0.2.1:9000"), IsOkAnd(false));
  EXPECT_THAT(stays("srt://:9000?mode=listener"), IsOkAnd(false)) << "every address of the machine";
  EXPECT_THAT(stays("udp://nosuch.invalid:9000"), FailsWith(ErrorCode::NotFound, "nosuch.invalid"));
}

}  // namespace
}  // namespace floatstage::capture
