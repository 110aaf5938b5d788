#include "studio/node/page_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/http_client.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kToken = "0123456789abcdef0123";
constexpr const char* kRight = "Authorization: Bearer 0123456789abcdef0123";

/// A studio that notes what it is asked.
class NotingControl final : public StudioControl {
 public:
  NodeStatus status() const override {
    NodeStatus status;
    status.node = "noting";
    status.cameras.resize(2);
    status.cameras[1].serial = "B";
    return status;
  }
  Result<std::string> start_recording(const std::string& label) override {
    if (recording_) return fail(ErrorCode::AlreadyExists, "'x' is being recorded");
    recording_ = true;
    return "take-" + label;
  }
  Result<void> stop_recording() override {
    if (!std::exchange(recording_, false)) return fail(ErrorCode::NotFound, "no take is being recorded");
    return {};
  }
  Result<std::vector<NodeTake>> takes() const override { return std::vector<NodeTake>(1); }

 private:
  bool recording_ = false;
};

class APage : public testing::Test {
 protected:
  void SetUp() override {
    auto server = PageServer::serve(control_, 2, {0, "127.0.0.1", {}}, kToken);
    ASSERT_THAT(server, IsOk());
    server_ = std::move(*server);
  }
  HttpAnswer get(const std::string& path, const std::vector<std::string>& headers = {kRight}) {
    return http_request(server_->port(), "GET", path, headers);
  }
  HttpAnswer post(const std::string& path, const std::vector<std::string>& headers = {kRight}) {
    return http_request(server_->port(), "POST", path, headers);
  }

  NotingControl control_;
  std::unique_ptr<PageServer> server_;
};

TEST_F(APage, OpensToItsTokenAlone) {
  for (const char* path : {"/", "/page.js", "/api/status", "/api/takes", "/metrics", "/nothing"}) {
    EXPECT_EQ(get(path, {}).status, 401) << path;
    EXPECT_EQ(get(path, {"Authorization: Bearer 0123456789abcdef0124"}).status, 401) << path;
    EXPECT_EQ(get(path, {"Authorization: Bearer 0123456789abcdef012"}).status, 401) << path;
    EXPECT_EQ(get(std::string(path) + "?token=wrong", {}).status, 401) << path;
    EXPECT_EQ(get(path, {"Cookie: floatstage_1=0123456789abcdef0123"}).status, 401) << path;
  }
  EXPECT_EQ(server_->counters().refused, 30u);
  EXPECT_EQ(post("/api/record", {}).status, 401);
  EXPECT_THAT(control_.stop_recording(), FailsWith(ErrorCode::NotFound, "")) << "nothing was begun";
  EXPECT_EQ(get("/").status, 200);
  EXPECT_EQ(get("/nothing").status, 404);
  EXPECT_THAT(get("/metrics").body, HasSubstr("floatstage_page_refused_total 31\n"));
}

TEST_F(APage, ExchangesTheTokenOfItsAddressForACookie) {
  const HttpAnswer answer = get(std::string("/?token=") + kToken, {});
  EXPECT_EQ(answer.status, 303);
  EXPECT_THAT(answer.headers, HasSubstr("Location: /\r\n"));
  const std::string cookie = "floatstage_" + std::to_string(server_->port()) + "=" + kToken;
  EXPECT_THAT(answer.headers, HasSubstr("Set-Cookie: " + cookie + "; Path=/; HttpOnly; SameSite=Strict"));
  EXPECT_THAT(get("/", {"Cookie: " + cookie}).body, HasSubstr("<!doctype html>"));
}

TEST_F(APage, TakesCommands) {
  EXPECT_EQ(get("/api/record").status, 405) << "a link must not begin a take";
  const HttpAnswer begun = post("/api/record?label=one");
  EXPECT_EQ(begun.status, 200);
  EXPECT_EQ(nlohmann::json::parse(begun.body)["take"], "take-one");
  const HttpAnswer again = post("/api/record");
  EXPECT_EQ(again.status, 409);
  EXPECT_EQ(nlohmann::json::parse(again.body)["error"], "'x' is being recorded");
  EXPECT_EQ(post("/api/stop").status, 200);
  EXPECT_EQ(post("/api/stop").status, 409);
}

TEST_F(APage, SendsStatusAndPreviewsOverOneConnection) {
  WebSocketClient stranger(server_->port(), "/live");
  EXPECT_EQ(stranger.status(), 401);
  WebSocketClient viewer(server_->port(), "/live", {kRight});
  ASSERT_EQ(viewer.status(), 101);
  FrameInfo info;
  info.camera = 1;
  const Frame frame = make_frame(info, Image(640, 480, 3));
  bool status = false, picture = false;
  while (!status || !picture) {
    server_->offer(frame);
    const WebSocketClient::Message message = viewer.next();
    ASSERT_NE(message.kind, 0);
    if (message.kind == 1) {
      EXPECT_EQ(nlohmann::json::parse(message.bytes)["node"], "noting");
      status = true;
    } else {
      EXPECT_EQ(message.bytes.substr(0, 3), std::string("\x01\xff\xd8", 3))
          << "the camera's number, then a JPEG";
      picture = true;
    }
  }
  EXPECT_EQ(server_->counters().viewers, 1u);
}

TEST_F(APage, IsNotHeldUpByAViewerThatNeverReads) {
  WebSocketClient lazy(server_->port(), "/live", {kRight});
  ASSERT_EQ(lazy.status(), 101);
  const auto viewers =
      std::make_unique<WebSocketClient>(server_->port(), "/live", std::vector<std::string>{kRight});
  for (int read = 0; read < 3;) read += viewers->next().kind == 1;
  EXPECT_EQ(get("/api/status").status, 200);
}

TEST_F(APage, SurvivesHostileRequests) {
  for (const std::string& bytes :
       {std::string("\0\0\0\0", 4), std::string(100'000, 'A'), std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("POST /api/record HTTP/1.1\r\nContent-Length: -5\r\n\r\n")})
    http_request(server_->port(), bytes, "/", {});
  EXPECT_EQ(get("/../../etc/passwd").status, 404);
  EXPECT_EQ(get("/%2e%2e/%2e%2e/etc/passwd").status, 404);
  EXPECT_EQ(get("/api/status").status, 200);
}

TEST(PageToken, IsRandomOrOfAFile) {
  const TempFolder folder;
  EXPECT_NE(*page_token({}), *page_token({}));
  EXPECT_EQ(page_token({})->size(), 32u);
  EXPECT_EQ(*page_token(folder.write("token", "abcdefgh-12345678_x\n")), "abcdefgh-12345678_x");
  EXPECT_THAT(page_token(folder.write("short", "abc\n")), FailsWith(ErrorCode::InvalidArgument, "short"));
  EXPECT_THAT(page_token(folder.write("odd", "abcdefgh 12345678\n")),
              FailsWith(ErrorCode::InvalidArgument, "odd"));
  EXPECT_THAT(page_token(folder / "none"), FailsWith(ErrorCode::NotFound, "none"));
}

TEST(PageServer, RefusesAPortThatIsTaken) {
  NotingControl control;
  auto first = PageServer::serve(control, 1, {0, "127.0.0.1", {}}, kToken);
  ASSERT_THAT(first, IsOk());
  EXPECT_THAT(PageServer::serve(control, 1, {(*first)->port(), "127.0.0.1", {}}, kToken),
              FailsWith(ErrorCode::Io, "is the port taken?"));
}

}  // namespace
}  // namespace floatstage::studio
