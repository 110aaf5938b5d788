#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/frame.h"
#include "core/result.h"

namespace floatstage::capture {

/// The options of a source's URI, "key=value&key=value", each read once and checked. The first thing that is
/// wrong is kept; finish() returns it, or that there was a key which nobody asked for.
class UriOptions {
 public:
  /// `uri` is for the errors.
  UriOptions(std::string_view options, std::string uri);

  /// The value of `key`, or `otherwise` when it is not there; a note when it is not a number of [low, high].
  int integer(const std::string& key, int otherwise, int low, int high);
  std::uint64_t whole(const std::string& key, std::uint64_t otherwise);
  double number(const std::string& key, double otherwise, double low, double high);
  std::string word(const std::string& key, std::string otherwise);
  /// "on" or "off".
  bool flag(const std::string& key, bool otherwise);
  /// format=; absent when it is not there.
  std::optional<PixelFormat> format();

  /// Notes what else is wrong.
  void note(std::string problem);

  /// InvalidArgument with a sentence that names the URI and what is understood.
  Result<void> finish(std::string_view usage) const;

 private:
  const std::string* take(const std::string& key);

  struct Value {
    std::string text;
    bool used = false;
  };
  const std::string uri_;
  std::map<std::string, Value> values_;
  std::string problem_;
};

/// A device's URI after its scheme, "<device>?key=value&…": the device's name, and its options.
struct DeviceUri {
  DeviceUri(const std::string& address, const std::string& uri);

  /// What every device may be asked for: format=, width= and height=, rate=, buffers= (2 to `most_buffers`).
  /// Notes a device without a name. The settings' own values are the defaults.
  template <class Settings>
  void read_pictures(Settings& s, int most_buffers);
  /// frames=; UINT64_MAX when the stream does not end.
  std::uint64_t frames();

  std::string device;
  UriOptions options;
};

template <class Settings>
void DeviceUri::read_pictures(Settings& s, int most_buffers) {
  if (device.empty()) options.note("the camera's name is missing");
  s.format = options.format();
  s.width = options.integer("width", 0, 0, 65535);
  s.height = options.integer("height", 0, 0, 65535);
  if ((s.width > 0) != (s.height > 0)) options.note("width and height go together");
  if (const double rate = options.number("rate", 0, 0.001, 100'000); rate > 0) s.frame_rate = rate;
  s.buffers = options.integer("buffers", s.buffers, 2, most_buffers);
}

}  // namespace floatstage::capture
