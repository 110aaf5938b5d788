#include "tests/support/browser.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/text.h"
#include "tests/support/http_client.h"

namespace floatstage {
namespace {

std::string from_base64(const std::string& encoded) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, held = 0;
  for (const char c : encoded) {
    const std::size_t six = kLetters.find(c);
    if (six == std::string_view::npos) continue;
    bits = bits << 6 | static_cast<unsigned>(six);
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes += static_cast<char>(bits >> held & 0xff);
    }
  }
  return bytes;
}

}  // namespace

Browser::Browser(int width, int height) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  driver_ = ::fork();
  if (driver_ == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // a test that is cut off leaves no browser behind
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
    ::execlp("chromedriver", "chromedriver", "--port=0", nullptr);
    ::_exit(127);
  }
  ::close(ends[1]);
  // "ChromeDriver was started successfully on port 12345."
  FILE* output = ::fdopen(ends[0], "r");
  char line[512];
  while (port_ == 0 && std::fgets(line, sizeof line, output))
    if (const char* at = std::strstr(line, "on port ")) port_ = std::atoi(at + 8);
  std::fclose(output);
  if (port_ == 0) throw std::runtime_error("chromedriver does not start; is chromium-driver installed?");
  const nlohmann::json options = {
      {"args",
       {"--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
        "--no-first-run", "--disable-background-networking", "--enable-unsafe-swiftshader",
        text("--window-size=", width, ",", height)}}};
  const nlohmann::json session =
      command("POST", "/session", {{"capabilities", {{"alwaysMatch", {{"goog:chromeOptions", options}}}}}});
  session_ = "/session/" + session["sessionId"].get<std::string>();
}

Browser::~Browser() {
  if (!session_.empty()) http_request(port_, "DELETE", session_);
  if (driver_ <= 0) return;
  ::kill(-driver_, SIGTERM);
  ::waitpid(driver_, nullptr, 0);
}

nlohmann::json Browser::command(const char* method, const std::string& path, const nlohmann::json& body) {
  const HttpAnswer answer = http_request(port_, method, path, {"Content-Type: application/json"},
                                         std::string_view(method) == "GET" ? "" : body.dump());
  const nlohmann::json json = nlohmann::json::parse(answer.body, nullptr, false);
  if (answer.status != 200 || !json.contains("value"))
    throw std::runtime_error(
        text("the browser: ", method, " ", path, ": ", answer.status, " ", answer.body.substr(0, 500)));
  return json["value"];
}

void Browser::open(const std::string& url) { command("POST", session_ + "/url", {{"url", url}}); }

void Browser::resize(int width, int height) {
  command("POST", session_ + "/goog/cdp/execute",
          {{"cmd", "Emulation.setDeviceMetricsOverride"},
           {"params",
            {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", width < 600}}}});
}

nlohmann::json Browser::value(const std::string& expression) {
  return command("POST", session_ + "/execute/sync",
                 {{"script", "return (" + expression + ");"}, {"args", nlohmann::json::array()}});
}

bool Browser::becomes_true(const std::string& expression, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (value(expression) == true) return true;
    ::poll(nullptr, 0, 50);
  }
  return false;
}

std::string Browser::element(const std::string& selector) {
  const nlohmann::json found =
      command("POST", session_ + "/element", {{"using", "css selector"}, {"value", selector}});
  return session_ + "/element/" + found.begin().value().get<std::string>();
}

void Browser::click(const std::string& selector) {
  command("POST", element(selector) + "/click", nlohmann::json::object());
}

void Browser::type(const std::string& selector, const std::string& words) {
  command("POST", element(selector) + "/value", {{"text", words}});
}

void Browser::screenshot(const std::filesystem::path& png) {
  const std::string bytes = from_base64(command("GET", session_ + "/screenshot", {}).get<std::string>());
  std::ofstream(png, std::ios::binary) << bytes;
}

}  // namespace floatstage
