#include "capture/source_uri.h"

#include <algorithm>
#include <charconv>
#include <climits>

#include "core/text.h"

namespace floatstage::capture {
namespace {

template <class T>
bool parse(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

UriOptions::UriOptions(std::string_view options, std::string uri) : uri_(std::move(uri)) {
  while (!options.empty()) {
    const std::string_view option = options.substr(0, options.find('&'));
    options.remove_prefix(std::min(options.size(), option.size() + 1));
    const std::size_t equals = option.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      note(text("'", option, "' is not key=value"));
      continue;
    }
    const std::string key(option.substr(0, equals));
    if (!values_.emplace(key, Value{std::string(option.substr(equals + 1))}).second)
      note(text("'", key, "' is given twice"));
  }
}

void UriOptions::note(std::string problem) {
  if (problem_.empty()) problem_ = std::move(problem);
}

const std::string* UriOptions::take(const std::string& key) {
  const auto found = values_.find(key);
  if (found == values_.end()) return nullptr;
  found->second.used = true;
  return &found->second.text;
}

int UriOptions::integer(const std::string& key, int otherwise, int low, int high) {
  int value = otherwise;
  const std::string* given = take(key);
  if (given && (!parse(*given, value) || value < low || value > high))
    note(text(key, "=", *given, " is not a whole number from ", low, " to ", high));
  return value;
}

std::uint64_t UriOptions::whole(const std::string& key, std::uint64_t otherwise) {
  std::uint64_t value = otherwise;
  const std::string* given = take(key);
  if (given && !parse(*given, value)) note(text(key, "=", *given, " is not a whole number from 0"));
  return value;
}

double UriOptions::number(const std::string& key, double otherwise, double low, double high) {
  double value = otherwise;
  const std::string* given = take(key);
  if (given && (!parse(*given, value) || !(value >= low && value <= high)))
    note(text(key, "=", *given, " is not a number from ", low, " to ", high));
  return value;
}

std::string UriOptions::word(const std::string& key, std::string otherwise) {
  const std::string* given = take(key);
  return given ? *given : otherwise;
}

bool UriOptions::flag(const std::string& key, bool otherwise) {
  const std::string* given = take(key);
  if (given && *given != "on" && *given != "off") note(text(key, "=", *given, " is neither on nor off"));
  return given ? *given == "on" : otherwise;
}

std::optional<PixelFormat> UriOptions::format() {
  const std::string* given = take("format");
  if (!given || given->empty()) return std::nullopt;
  const std::optional<PixelFormat> format = pixel_format_named(*given);
  if (!format) note(text("format=", *given, " is no pixel format"));
  return format;
}

Result<void> UriOptions::finish(std::string_view usage) const {
  std::string problem = problem_;
  for (const auto& [key, value] : values_)
    if (!value.used && problem.empty()) problem = text("unknown option '", key, "'");
  if (problem.empty()) return {};
  return fail(ErrorCode::InvalidArgument, text("source '", uri_, "': ", problem, "; understood is ", usage));
}

DeviceUri::DeviceUri(const std::string& address, const std::string& uri)
    : device(address.substr(0, address.find('?'))),
      options(std::string_view(address).substr(std::min(address.size(), device.size() + 1)), uri) {}

std::uint64_t DeviceUri::frames() {
  const int frames = options.integer("frames", 0, 0, INT_MAX - 1);
  return frames > 0 ? static_cast<std::uint64_t>(frames) : UINT64_MAX;
}

}  // namespace floatstage::capture
