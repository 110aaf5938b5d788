#pragma once

#include <string>
#include <string_view>

namespace floatstage {

/// 128 bits of what bytes say, as 32 hexadecimal digits: names what was made from them in caches. Nobody who
/// wants two inputs of one hash is kept from it; capture/sha256.h is for that.
std::string content_hash(std::string_view bytes);

}  // namespace floatstage
