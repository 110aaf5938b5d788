#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "apps/terminal/flags.h"
#include "capture/stream/stream_output.h"

namespace floatstage::apps {

/// --stream and what goes with it, the same for `live` and `live view`.
struct StreamFlags {
  std::string url;  ///< empty: none
  double fps = 25;
  int kbit = 8000;
  Size size{0, 0};  ///< 0: the view's; in a window 1280x720
};

void add_stream_flags(CLI::App& verb, StreamFlags& flags);

/// InvalidArgument for flags that cannot be. `view`: what the size is where none is said.
Result<void> settle(StreamFlags& flags, Size view);

/// Null where none is asked for. Errors: those of StreamOutput::open().
Result<std::unique_ptr<capture::StreamOutput>> open_stream(const StreamFlags& flags);

/// What became of it, for --json, and a line for people.
nlohmann::ordered_json to_json(const capture::StreamOutput& stream, const StreamFlags& flags);
void print_stream(const capture::StreamOutput& stream);

}  // namespace floatstage::apps
