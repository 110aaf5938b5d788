#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace floatstage {

/// Commands of a page's ```sh block, and the lines of the ```text block that follows it, if one does.
struct TutorialStep {
  int line;  ///< of the page, from 1, of the first command
  std::string commands;
  std::vector<std::string> expected;  ///< `…` stands for anything, nothing too
};

/// The steps of a page in Markdown, in their order.
std::vector<TutorialStep> tutorial_steps(std::string_view page);

/// Whether a line of output is what the page shows: in it, with anything where the page says `…`.
bool shows(std::string_view output_line, std::string_view expected);

/// The first expected line that no line of the output is; empty where there is none.
std::string first_missing(const TutorialStep& step, std::string_view output);

}  // namespace floatstage
