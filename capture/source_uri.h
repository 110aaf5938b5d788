#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "core/result.h"

namespace floatstage {

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

  /// InvalidArgument with a sentence that names the URI and what is understood.
  Result<void> finish(std::string_view usage) const;

 private:
  void note(std::string problem);
  const std::string* take(const std::string& key);

  struct Value {
    std::string text;
    bool used = false;
  };
  const std::string uri_;
  std::map<std::string, Value> values_;
  std::string problem_;
};

}  // namespace floatstage
