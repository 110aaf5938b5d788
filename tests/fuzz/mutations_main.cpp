// Runs a fuzzer's entry over seeds and their mutations, with any compiler:
// `mutations <what> <folder of seeds>`. After a failure, `mutations <what> <file>` runs the one input that
// was written to the working folder.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

#include <signal.h>
#include <unistd.h>

#include "core/file.h"
#include "tests/fuzz/mutations.h"

#define FLOATSTAGE_ENTRY(what) extern "C" int fuzz_##what(const std::uint8_t* data, std::size_t size);
#include "fuzz_entries.inc"
#undef FLOATSTAGE_ENTRY

namespace {

struct Entry {
  std::string_view what;
  int (*run)(const std::uint8_t* data, std::size_t size);
};
constexpr Entry kEntries[] = {
#define FLOATSTAGE_ENTRY(what) {#what, fuzz_##what},
#include "fuzz_entries.inc"
#undef FLOATSTAGE_ENTRY
};

char g_at[256];  // which input is being run, for the signal handler

extern "C" void say_where(int signal_number) {
  ssize_t ignored = ::write(STDERR_FILENO, g_at, std::char_traits<char>::length(g_at));
  static_cast<void>(ignored);
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);
}

bool run(const Entry& entry, const std::string& input, const char* seed, std::size_t index) {
  std::snprintf(g_at, sizeof g_at, "crashed at mutation %zu of seed %s\n", index, seed);
  // An exact copy on the heap, so that the address sanitizer sees a read past the end.
  const std::vector<std::uint8_t> exact(input.begin(), input.end());
  try {
    entry.run(exact.data(), exact.size());
    return true;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mutation %zu of seed %s: %s\nthe input is in failing-input\n", index, seed,
                 e.what());
  } catch (...) {
    std::fprintf(stderr, "mutation %zu of seed %s threw\nthe input is in failing-input\n", index, seed);
  }
  std::ofstream("failing-input", std::ios::binary) << input;
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  const auto entry = std::find_if(std::begin(kEntries), std::end(kEntries),
                                  [&](const Entry& e) { return argc == 3 && e.what == argv[1]; });
  if (entry == std::end(kEntries)) {
    std::fprintf(stderr, "usage: %s <what> <folder of seeds, or one file>, where what is one of\n", argv[0]);
    for (const Entry& e : kEntries) std::fprintf(stderr, "  %s\n", e.what.data());
    return 2;
  }
  for (int s : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) ::signal(s, say_where);
  std::vector<std::filesystem::path> seeds;
  const bool one = std::filesystem::is_regular_file(argv[2]);
  if (one)
    seeds = {argv[2]};
  else if (std::filesystem::is_directory(argv[2]))
    for (const auto& file : std::filesystem::directory_iterator(argv[2])) seeds.push_back(file.path());
  std::sort(seeds.begin(), seeds.end());
  std::size_t inputs = 0;
  for (const std::filesystem::path& seed : seeds) {
    const floatstage::Result<std::string> bytes = floatstage::read_file(seed);
    if (!bytes) {
      std::fprintf(stderr, "%s\n", bytes.error().message.c_str());
      return 1;
    }
    const std::string name = seed.filename().string();
    const std::size_t count = floatstage::mutation_count(bytes->size());
    if (!run(*entry, *bytes, name.c_str(), count)) return 1;
    for (std::size_t i = 0; !one && i < count; ++i, ++inputs)
      if (!run(*entry, floatstage::mutated(*bytes, i), name.c_str(), i)) return 1;
  }
  if (seeds.empty()) {
    std::fprintf(stderr, "%s: no seeds\n", argv[2]);
    return 1;
  }
  std::printf("%zu seeds, %zu mutations\n", seeds.size(), inputs);
  return 0;
}
