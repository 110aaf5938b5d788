#pragma once

#include <map>
#include <string>
#include <string_view>

namespace floatstage::studio {

/// What the page's server needs to know of an HTTP request. Every string is what a stranger sent.
struct PageRequest {
  std::string method;
  std::string path;                          ///< "/api/record", decoded
  std::map<std::string, std::string> query;  ///< decoded; of one name given twice, the first
  std::string host, origin, authorization, cookies;

  /// Of `name` in the query or in the cookies; empty where there is none.
  std::string query_value(const std::string& name) const;
  std::string cookie(std::string_view name) const;
};

/// Splits "/api/record?label=one%20two" (RFC 3986, with '+' for a space as forms send it). What is no valid
/// escape stays as it is.
void read_target(std::string_view target, PageRequest& request);

}  // namespace floatstage::studio
