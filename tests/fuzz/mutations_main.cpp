// Runs a fuzzer's entry over seeds and their mutations, with any compiler: `<program> <folder of seeds>`.
// After a failure, `<program> <file>` runs the one input that was written to the working folder.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <vector>

#include <signal.h>
#include <unistd.h>

#include "core/file.h"
#include "tests/fuzz/mutations.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

char g_at[256];  // which input is being run, for the signal handler

extern "C" void say_where(int signal_number) {
  ssize_t ignored = ::write(STDERR_FILENO, g_at, std::char_traits<char>::length(g_at));
  static_cast<void>(ignored);
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);
}

bool run(const std::string& input, const char* seed, std::size_t index) {
  std::snprintf(g_at, sizeof g_at, "crashed at mutation %zu of seed %s\n", index, seed);
  // An exact copy on the heap, so that the address sanitizer sees a read past the end.
  const std::vector<std::uint8_t> exact(input.begin(), input.end());
  try {
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
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
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s <folder of seeds, or one file>\n", argv[0]);
    return 2;
  }
  for (int s : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) ::signal(s, say_where);
  std::vector<std::filesystem::path> seeds;
  const bool one = std::filesystem::is_regular_file(argv[1]);
  if (one)
    seeds = {argv[1]};
  else if (std::filesystem::is_directory(argv[1]))
    for (const auto& entry : std::filesystem::directory_iterator(argv[1])) seeds.push_back(entry.path());
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
    if (!run(*bytes, name.c_str(), count)) return 1;
    for (std::size_t i = 0; !one && i < count; ++i, ++inputs)
      if (!run(floatstage::mutated(*bytes, i), name.c_str(), i)) return 1;
  }
  if (seeds.empty()) {
    std::fprintf(stderr, "%s: no seeds\n", argv[1]);
    return 1;
  }
  std::printf("%zu seeds, %zu mutations\n", seeds.size(), inputs);
  return 0;
}
