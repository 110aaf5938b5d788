#include "core/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace floatstage::log {
namespace {

// spdlog's own registry holds the logger; this only makes sure that it writes to standard error.
spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto l = spdlog::stderr_color_mt("floatstage");
    l->set_pattern("%H:%M:%S.%e %^%l%$ %v");
    return l;
  }();
  return *instance;
}

}  // namespace

void set_level(Level level) {
  constexpr spdlog::level::level_enum kLevels[] = {
      spdlog::level::debug, spdlog::level::info, spdlog::level::warn, spdlog::level::err, spdlog::level::off};
  logger().set_level(kLevels[static_cast<int>(level)]);
}

void debug(std::string_view m) { logger().debug("{}", m); }
void info(std::string_view m) { logger().info("{}", m); }
void warning(std::string_view m) { logger().warn("{}", m); }
void error(std::string_view m) { logger().error("{}", m); }

}  // namespace floatstage::log
