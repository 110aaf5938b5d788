#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>
#include <sys/types.h>

namespace floatstage {

/// A headless Chromium, driven through chromedriver by the W3C's WebDriver protocol. Throws
/// std::runtime_error where a command fails: a test that uses it then fails with the browser's words.
class Browser {
 public:
  explicit Browser(int width = 1280, int height = 800);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void open(const std::string& url);
  void resize(int width, int height);
  /// The value of a JavaScript expression.
  nlohmann::json value(const std::string& expression);
  /// Asks again and again until the expression is true; false when it is not within `seconds`.
  bool becomes_true(const std::string& expression, double seconds = 30);
  /// A click of the mouse on the element that a CSS selector finds.
  void click(const std::string& selector);
  void type(const std::string& selector, const std::string& words);
  void screenshot(const std::filesystem::path& png);

 private:
  nlohmann::json command(const char* method, const std::string& path, const nlohmann::json& body);
  std::string element(const std::string& selector);

  pid_t driver_ = -1;
  int port_ = 0;
  std::string session_;
};

}  // namespace floatstage
