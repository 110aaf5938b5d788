#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "pipeline/calibrate/board_search.h"
#include "pipeline/calibrate/session_draft.h"
#include "tests/fuzz/scratch_folder.h"

// What other programs leave beside pictures of a board: its description (TOML), and a table of times.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::filesystem::path file = fuzz_file("board.toml", bytes);
  if (const auto board = pipeline::read_board_file(file); !board)
    FLOATSTAGE_CHECK(board.error().message.find("board.toml") != std::string::npos,
                     "a file that is not named");
  if (const auto rate = pipeline::rate_of_time_stamps(file))
    FLOATSTAGE_CHECK(std::isfinite(*rate) && *rate >= 0, "a rate that is none");
  return 0;
}
