#include "studio/page/page_server.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <span>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/jpeg.h"
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

  std::vector<NodeControls> controls() const override {
    return {{"A", {{"gain", 2, 0, 24, 0.5}}}, {"B", {}}};
  }
  Result<void> set_control(const std::string& serial, const std::string& name, double value) override {
    if (value > 24) return fail(ErrorCode::InvalidArgument, "it takes 0 to 24");
    return note(text(serial, ".", name, "=", value));
  }
  Result<std::vector<std::string>> presets() const override { return std::vector<std::string>{"day"}; }
  Result<void> save_preset(const std::string& name) override { return note("save " + name); }
  Result<void> apply_preset(const std::string& name) override {
    if (name != "day") return fail(ErrorCode::NotFound, "there is no preset 'night'");
    return note("apply " + name);
  }
  std::vector<std::string> noted() {
    std::lock_guard lock(mutex_);
    return noted_;
  }

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
  Result<void> note(const std::string& what) {
    std::lock_guard lock(mutex_);
    noted_.push_back(what);
    return {};
  }

  std::vector<std::string> noted_;
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

TEST_F(APage, TurnsKnobsOfCameras) {
  const nlohmann::json all = nlohmann::json::parse(get("/api/controls").body);
  const nlohmann::json gain = {{"name", "gain"}, {"value", 2}, {"least", 0}, {"most", 24}, {"step", 0.5}};
  EXPECT_EQ(all["cameras"][0]["serial"], "A");
  EXPECT_EQ(all["cameras"][0]["controls"], nlohmann::json::array({gain}));
  EXPECT_EQ(all["presets"], nlohmann::json::array({"day"}));
  EXPECT_EQ(post("/api/control?camera=A&name=gain&value=6.5").status, 200);
  EXPECT_EQ(post("/api/preset/save?name=night").status, 200);
  EXPECT_EQ(post("/api/preset/apply?name=day").status, 200);
  EXPECT_THAT(control_.noted(), testing::ElementsAre("A.gain=6.5", "save night", "apply day"));
  const HttpAnswer refused = post("/api/control?camera=A&name=gain&value=25");
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(nlohmann::json::parse(refused.body)["error"], "it takes 0 to 24");
  EXPECT_EQ(post("/api/preset/apply?name=night").status, 409);
}

TEST_F(APage, TurnsNoKnobForWhoMayNotOrIsNotUnderstood) {
  const std::string knob = "/api/control?camera=A&name=gain&value=6";
  for (const std::string order : {knob.c_str(), "/api/preset/save?name=x", "/api/preset/apply?name=day"}) {
    EXPECT_EQ(get(order).status, 405) << "a link must not turn a knob: " << order;
    EXPECT_EQ(post(order, {}).status, 401) << order;
    EXPECT_EQ(post(order, {kRight, "Origin: http://elsewhere.example"}).status, 403) << order;
  }
  EXPECT_EQ(get("/api/controls", {}).status, 401);
  EXPECT_EQ(get("/api/zoom?camera=0&x=0&y=0", {}).status, 401);
  for (const char* value : {"", "much", "nan", "inf", "-inf", "1e999", "6x", "%206", "0x10"}) {
    const HttpAnswer answer = post(std::string("/api/control?camera=A&name=gain&value=") + value);
    EXPECT_EQ(answer.status, 400) << value;
    EXPECT_THAT(answer.body, HasSubstr("camera 'A': gain = ")) << value;
  }
  EXPECT_THAT(control_.noted(), testing::IsEmpty());
}

TEST_F(APage, ShowsAPieceOfACamerasPictureAsItIs) {
  FrameInfo info;
  info.camera = 1;
  Image picture(1000, 600, 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) picture.at(x, y)[0] = x >= 900 && y >= 500 ? 200 : 20;
  const Frame frame = make_frame(info, picture);
  std::atomic<bool> done{false};
  std::thread camera([&] {
    for (; !done; std::this_thread::sleep_for(std::chrono::milliseconds(5))) server_->offer(frame);
  });
  const HttpAnswer corner = get("/api/zoom?camera=1&x=1&y=1");
  const HttpAnswer middle = get("/api/zoom?camera=1&x=0.5&y=0.5");
  const HttpAnswer dark = get("/api/zoom?camera=0&x=0.5&y=0.5");
  done = true;
  camera.join();
  ASSERT_EQ(corner.status, 200);
  const Result<Image> shown = decode_jpeg(std::as_bytes(std::span(corner.body)), 320, 240);
  ASSERT_THAT(shown, IsOk());
  // The right 100 px and the lower 100 px of it are bright.
  EXPECT_NEAR(shown->at(230, 150)[0], 200, 12);
  EXPECT_NEAR(shown->at(210, 150)[0], 20, 12);
  EXPECT_NEAR(shown->at(230, 130)[0], 20, 12);
  EXPECT_EQ(middle.status, 200);
  EXPECT_EQ(dark.status, 409) << "that camera sends nothing";
  for (const char* bad : {"", "?camera=2&x=0&y=0", "?camera=-1&x=0&y=0", "?camera=0.5&x=0&y=0",
                          "?camera=0&x=1.1&y=0", "?camera=0&x=0&y=nan", "?camera=1e300&x=0&y=0"})
    EXPECT_EQ(get(std::string("/api/zoom") + bad).status, 400) << bad;
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
