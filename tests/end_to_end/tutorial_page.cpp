#include "tests/end_to_end/tutorial_page.h"

#include <algorithm>

namespace floatstage {
namespace {

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace

std::vector<TutorialStep> tutorial_steps(std::string_view page) {
  std::vector<TutorialStep> steps;
  enum class In { Prose, Commands, Output, Other } in = In::Prose;
  bool may_show_output = false;  // only what stands after commands, with nothing but empty lines between
  int number = 0;
  for (const std::string_view line : lines_of(page)) {
    ++number;
    if (line.starts_with("```")) {
      if (in != In::Prose) {
        may_show_output = in == In::Commands;
        in = In::Prose;
      } else if (line == "```sh") {
        steps.push_back({.line = number + 1, .commands = {}, .expected = {}});
        in = In::Commands;
      } else {
        in = line == "```text" && may_show_output ? In::Output : In::Other;
      }
    } else if (in == In::Commands) {
      steps.back().commands += std::string(line) + "\n";
    } else if (in == In::Output) {
      steps.back().expected.emplace_back(line);
    } else if (in == In::Prose && !line.empty()) {
      may_show_output = false;
    }
  }
  return steps;
}

bool shows(std::string_view output_line, std::string_view expected) {
  constexpr std::string_view kAnything = "…";
  std::size_t at = 0;
  while (!expected.empty()) {
    const std::size_t end = std::min(expected.find(kAnything), expected.size());
    std::string_view part = expected.substr(0, end);
    expected.remove_prefix(std::min(end + kAnything.size(), expected.size()));
    while (part.ends_with(' ')) part.remove_suffix(1);  // columns are as wide as their widest entry
    while (part.starts_with(' ')) part.remove_prefix(1);
    const std::size_t found = output_line.find(part, at);
    if (found == std::string_view::npos) return false;
    at = found + part.size();
  }
  return true;
}

std::string first_missing(const TutorialStep& step, std::string_view output) {
  const std::vector<std::string_view> lines = lines_of(output);
  for (const std::string& expected : step.expected)
    if (std::none_of(lines.begin(), lines.end(),
                     [&](std::string_view line) { return shows(line, expected); }))
      return expected;
  return {};
}

}  // namespace floatstage
