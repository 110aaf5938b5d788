#include "studio/page/page_answers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/jpeg.h"
#include "core/text.h"
#include "studio/messages/status_json.h"

namespace floatstage::studio {
namespace {

constexpr int kZoomQuality = 92;  // JPEG's own edges are no focus

std::string as_text(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

PageAnswer json_answer(std::string json) { return {200, "application/json", std::move(json), {}}; }

PageAnswer answer_of(const Error& error) {
  const auto status = [&] {
    switch (error.code) {
      case ErrorCode::AlreadyExists:
      case ErrorCode::NotFound:
      case ErrorCode::Unsupported:
        return 409;
      case ErrorCode::InvalidArgument:
        return 400;
      case ErrorCode::Timeout:
        return 504;
      default:
        return 500;
    }
  };
  return {status(), "application/json", as_text({{"error", error.message}}), {}};
}

PageAnswer answer_of(const Result<void>& done) { return done ? json_answer("{}") : answer_of(done.error()); }

// Of a query's value: all of it is a finite number.
std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

Result<void> set_control(StudioControl& control, const PageRequest& order) {
  const std::string camera = order.query_value("camera"), name = order.query_value("name");
  const std::string given = order.query_value("value");
  const std::optional<double> value = number_of(given);
  if (!value)
    return fail(ErrorCode::InvalidArgument,
                text("camera '", camera, "': ", name, " = '", given, "' is no number"));
  return control.set_control(camera, name, *value);
}

std::string controls_json(const StudioControl& control) {
  nlohmann::json cameras = nlohmann::json::array();
  for (const NodeControls& camera : control.controls()) {
    nlohmann::json knobs = nlohmann::json::array();
    for (const capture::CameraControl& c : camera.controls)
      knobs.push_back(
          {{"name", c.name}, {"value", c.value}, {"least", c.least}, {"most", c.most}, {"step", c.step}});
    cameras.push_back({{"serial", camera.serial}, {"controls", knobs}});
  }
  const Result<std::vector<std::string>> presets = control.presets();
  return as_text({{"cameras", cameras},
                  {"presets", presets ? *presets : std::vector<std::string>()},
                  {"trouble", presets ? "" : presets.error().message}});
}

}  // namespace

bool is_order_to_cameras(const PageRequest& request) {
  constexpr std::array kPaths = {"/api/control", "/api/preset/save", "/api/preset/apply"};
  return std::find(kPaths.begin(), kPaths.end(), request.path) != kPaths.end();
}

bool is_order(const PageRequest& request) {
  return request.path == "/api/record" || request.path == "/api/stop" || is_order_to_cameras(request);
}

PageAnswer carry_out(StudioControl& control, const PageRequest& order) {
  if (order.path == "/api/stop") return answer_of(control.stop_recording());
  if (order.path == "/api/control") return answer_of(set_control(control, order));
  if (order.path == "/api/preset/save") return answer_of(control.save_preset(order.query_value("name")));
  if (order.path == "/api/preset/apply") return answer_of(control.apply_preset(order.query_value("name")));
  const Result<std::string> take = control.start_recording(order.query_value("label"));
  return take ? json_answer(as_text({{"take", *take}})) : answer_of(take.error());
}

bool is_question(const PageRequest& request) {
  constexpr std::array kPaths = {"/api/status", "/api/takes", "/api/controls", "/metrics"};
  return std::find(kPaths.begin(), kPaths.end(), request.path) != kPaths.end();
}

PageAnswer answer_question(const StudioControl& control, const std::string& path) {
  if (path == "/api/status") return json_answer(wire::to_json(control.status()));
  if (path == "/api/controls") return json_answer(controls_json(control));
  const Result<std::vector<NodeTake>> takes = control.takes();
  return takes ? json_answer(wire::to_json(*takes)) : answer_of(takes.error());
}

PageAnswer look(ZoomFeed& feed, std::size_t cameras, const PageRequest& request) {
  const auto whole = [](double value) { return value == std::floor(value); };
  const auto inside = [](const std::optional<double>& at) { return at && *at >= 0 && *at <= 1; };
  const std::optional<double> camera = number_of(request.query_value("camera"));
  const std::optional<double> x = number_of(request.query_value("x")),
                              y = number_of(request.query_value("y"));
  const bool there = camera && whole(*camera) && *camera >= 0 && *camera < static_cast<double>(cameras);
  if (!there || !inside(x) || !inside(y))
    return answer_of(Error{ErrorCode::InvalidArgument,
                           text("ask for camera=0 to ", cameras - 1, ", x and y from 0 to 1")});
  const Result<Image> piece = feed.look(static_cast<int>(*camera), *x, *y);
  if (!piece) return answer_of(piece.error());
  return {200, "image/jpeg", encode_jpeg(*piece, kZoomQuality), {}};
}

}  // namespace floatstage::studio
