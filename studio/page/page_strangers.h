#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "studio/page/page_connection.h"

namespace floatstage::studio {

/// Who has connected and not asked yet. Many of them cost little; when there are more than agreed, from one
/// address or in all, the one that has waited longest is closed: whoever asks at once is always heard.
class PageStrangers {
 public:
  PageStrangers(std::size_t most_of_an_address, std::size_t most)
      : most_of_an_address_(most_of_an_address), most_(most) {}

  /// Reads the request of one who comes from `address`, and gives it away. Must outlive the connections.
  void add(const std::shared_ptr<PageConnection>& connection, const std::string& address,
           PageConnection::Handler handler);
  void close();

 private:
  struct Stranger {
    std::weak_ptr<PageConnection> connection;
    std::string address;
  };
  using Waiting = std::map<std::uint64_t, Stranger>;
  void forget(std::uint64_t number);
  void turn_away(Waiting::iterator stranger);

  const std::size_t most_of_an_address_, most_;
  std::uint64_t next_ = 0;
  Waiting waiting_;  // by number: the longest first
  std::map<std::string, std::size_t> of_address_;
};

}  // namespace floatstage::studio
