#include "studio/page/page_strangers.h"

#include <algorithm>

namespace floatstage::studio {

void PageStrangers::add(const std::shared_ptr<PageConnection>& connection, const std::string& address,
                        PageConnection::Handler handler) {
  if (const auto many = of_address_.find(address);
      many != of_address_.end() && many->second >= most_of_an_address_)
    turn_away(std::find_if(waiting_.begin(), waiting_.end(),
                           [&](const auto& waiting) { return waiting.second.address == address; }));
  else if (waiting_.size() >= most_)
    turn_away(waiting_.begin());
  const std::uint64_t number = next_++;
  waiting_.emplace(number, Stranger{connection, address});
  ++of_address_[address];
  connection->read(std::move(handler), [this, number] { forget(number); });
}

void PageStrangers::forget(std::uint64_t number) {
  const auto stranger = waiting_.find(number);
  if (stranger == waiting_.end()) return;  // it was turned away
  const auto count = of_address_.find(stranger->second.address);
  if (--count->second == 0) of_address_.erase(count);
  waiting_.erase(stranger);
}

void PageStrangers::turn_away(Waiting::iterator stranger) {
  if (const std::shared_ptr<PageConnection> connection = stranger->second.connection.lock())
    connection->close();
  forget(stranger->first);
}

void PageStrangers::close() {
  while (!waiting_.empty()) turn_away(waiting_.begin());
}

}  // namespace floatstage::studio
