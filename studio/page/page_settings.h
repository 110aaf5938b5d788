#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace floatstage::studio {

/// Where a node's page is served, and to whom.
struct PageSettings {
  int port = 8470;                    ///< 0: any that is free
  std::string address = "127.0.0.1";  ///< of this machine; "0.0.0.0" and "::" are all of them
  std::filesystem::path token_file;   ///< holds the token; empty: a new one each time, which the log tells
  /// Names by which browsers may ask for it, beside addresses, localhost and this machine's own name.
  std::vector<std::string> names;
};

}  // namespace floatstage::studio
