#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "studio/network/keys.h"
#include "tests/fuzz/scratch_folder.h"

// The studio's keys, and addresses as a studio's file names them: without keys none leads off this machine.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  namespace fs = std::filesystem;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const fs::path file = fuzz_file("studio.keys", bytes);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  if (const auto keys = studio::wire::load_keys(file))
    FLOATSTAGE_CHECK(keys->public_key.size() == 40 && keys->secret_key.size() == 40,
                     "keys of another length");
  if (studio::wire::check_address(bytes, std::nullopt))
    FLOATSTAGE_CHECK(bytes.find(';') == std::string::npos && bytes.find("0.0.0.0") == std::string::npos,
                     "an address that others reach");
  return 0;
}
