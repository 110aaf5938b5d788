#include "studio/page/page_server.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/statistics.h"
#include "core/text.h"
#include "tests/support/eventually.h"
#include "tests/support/http_client.h"
#include "tests/support/matchers.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

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
    {
      std::unique_lock lock(mutex_);
      held_ = holding_;
      wake_.notify_all();
      wake_.wait(lock, [&] { return !holding_; });
    }
    if (recording_) return fail(ErrorCode::AlreadyExists, "'x' is being recorded");
    recording_ = true;
    return "take-" + label;
  }
  Result<void> stop_recording() override {
    if (!std::exchange(recording_, false)) return fail(ErrorCode::NotFound, "no take is being recorded");
    return {};
  }
  Result<std::vector<NodeTake>> takes() const override { return std::vector<NodeTake>(1); }

  /// The next take begins only when it is let go.
  void hold() { holding_ = true; }
  bool wait_until_held() {
    std::unique_lock lock(mutex_);
    return wake_.wait_for(lock, std::chrono::seconds(30), [&] { return held_; });
  }
  void let_go() {
    std::lock_guard lock(mutex_);
    holding_ = false;
    wake_.notify_all();
  }

 private:
  bool recording_ = false, holding_ = false, held_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
};

class APage : public testing::Test {
 protected:
  void SetUp() override {
    auto server = PageServer::serve(control_, 2, {0, "127.0.0.1", {}, {}}, kToken);
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

TEST_F(APage, ExchangesTheTokenOfItsAddressForACookieThatDoesNotTellIt) {
  const HttpAnswer answer = get(std::string("/?token=") + kToken, {});
  EXPECT_EQ(answer.status, 303);
  EXPECT_THAT(answer.headers, HasSubstr("Location: /\r\n"));
  EXPECT_THAT(answer.headers, Not(HasSubstr(kToken)));
  const std::size_t begin = answer.headers.find("Set-Cookie: ") + 12;
  const std::string cookie = answer.headers.substr(begin, answer.headers.find(';', begin) - begin);
  EXPECT_THAT(cookie, StartsWith("floatstage_" + std::to_string(server_->port()) + "="));
  EXPECT_THAT(answer.headers, HasSubstr(cookie + "; Path=/; HttpOnly; SameSite=Strict"));
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

TEST_F(APage, TakesNoOrderOfAnotherSitesPage) {
  const std::string own = "Origin: http://127.0.0.1:" + std::to_string(server_->port());
  EXPECT_EQ(post("/api/record", {kRight, "Origin: http://elsewhere.example"}).status, 403);
  EXPECT_EQ(post("/api/record", {kRight, own + "0"}).status, 403);
  EXPECT_THAT(control_.stop_recording(), FailsWith(ErrorCode::NotFound, "")) << "nothing was begun";
  EXPECT_EQ(post("/api/record", {kRight, own}).status, 200);
  EXPECT_EQ(WebSocketClient(server_->port(), "/live", {kRight, "Origin: null"}).status(), 403);
  EXPECT_EQ(server_->counters().refused, 3u);
}

TEST_F(APage, AnswersWhileHundredsWatchOrWait) {
  std::vector<std::unique_ptr<WebSocketClient>> viewers;
  for (int i = 0; i < 32; ++i) {
    viewers.push_back(
        std::make_unique<WebSocketClient>(server_->port(), "/live", std::vector<std::string>{kRight}));
    ASSERT_EQ(viewers.back()->status(), 101) << i;
  }
  std::vector<OpenConnection> strangers;
  for (int i = 0; i < 400; ++i)
    strangers.emplace_back(server_->port(), "POST /api/stop HTTP/1.1\r\nHost: 127");
  std::vector<double> stops;  // seconds
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(post("/api/record").status, 200);
    const auto asked = std::chrono::steady_clock::now();
    EXPECT_EQ(post("/api/stop").status, 200);
    stops.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count());
  }
  RecordProperty("stop_p99_ms", text(1e3 * percentile(stops, 0.99)));
  EXPECT_LE(percentile(stops, 0.99), 0.5);
  EXPECT_EQ(server_->counters().viewers, 32u);
  EXPECT_TRUE(eventually([&] { return strangers.front().is_closed(); }))
      << "of more than 256 from one address the first ones make room";
  EXPECT_FALSE(strangers.back().is_closed());
}

TEST_F(APage, CarriesOutNoOrderWhoseClientHasGone) {
  control_.hold();
  std::thread first([&] { EXPECT_EQ(post("/api/record").status, 200); });
  ASSERT_TRUE(control_.wait_until_held());
  {
    const OpenConnection impatient(server_->port(), text("POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1\r\n",
                                                         kRight, "\r\nContent-Length: 0\r\n\r\n"));
    ASSERT_TRUE(eventually([&] { return server_->counters().requests == 2; }));
  }
  EXPECT_EQ(get("/api/status").status, 200)
      << "questions do not wait for orders, and the server has seen it go";
  control_.let_go();
  first.join();
  EXPECT_EQ(post("/api/record").status, 409) << "the take goes on";
}

TEST(PageServer, RefusesWhatIsNoAddress) {
  NotingControl control;
  EXPECT_THAT(PageServer::serve(control, 1, {0, "localhost:80", {}, {}}, kToken),
              FailsWith(ErrorCode::InvalidArgument, "'localhost:80' in [web] is no address"));
}

TEST(PageServer, RefusesAPortThatIsTaken) {
  NotingControl control;
  auto first = PageServer::serve(control, 1, {0, "127.0.0.1", {}, {}}, kToken);
  ASSERT_THAT(first, IsOk());
  EXPECT_THAT(PageServer::serve(control, 1, {(*first)->port(), "127.0.0.1", {}, {}}, kToken),
              FailsWith(ErrorCode::Io, "is the port taken?"));
}

}  // namespace
}  // namespace floatstage::studio
