#include "tests/document_links.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <sstream>

#include "core/text.h"

namespace floatstage::architecture {
namespace {

bool is_fence(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(' ');
  return begin != std::string_view::npos && line.substr(begin).starts_with("```");
}

// The same text with what stands between backticks blanked.
std::string without_code(std::string line) {
  for (std::size_t open = line.find('`'); open != std::string::npos; open = line.find('`', open)) {
    const std::size_t close = line.find('`', open + 1);
    if (close == std::string::npos) break;
    std::fill(line.begin() + static_cast<std::ptrdiff_t>(open),
              line.begin() + static_cast<std::ptrdiff_t>(close) + 1, ' ');
  }
  return line;
}

template <class Visit>
void for_each_line_of_text(std::string_view markdown, Visit visit) {
  std::istringstream lines{std::string(markdown)};
  std::string line;
  bool fenced = false;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (is_fence(line))
      fenced = !fenced;
    else if (!fenced)
      visit(line, number);
  }
}

bool leads_to_another_site(std::string_view target) {
  return target.find("://") != std::string_view::npos || target.starts_with("mailto:");
}

// A path from the root of what `target` says in `document`.
std::string resolved(const std::string& document, const std::string& target) {
  if (target.empty()) return document;
  return (std::filesystem::path(document).parent_path() / target).lexically_normal().generic_string();
}

}  // namespace

std::vector<DocumentLink> links_of(std::string_view markdown) {
  std::vector<DocumentLink> links;
  for_each_line_of_text(markdown, [&](const std::string& raw, int number) {
    const std::string line = without_code(raw);
    for (std::size_t at = line.find("]("); at != std::string::npos; at = line.find("](", at + 1)) {
      const std::size_t end = line.find(')', at);
      if (end == std::string::npos) continue;
      const std::string target = line.substr(at + 2, end - at - 2);
      if (leads_to_another_site(target)) continue;
      const std::size_t hash = target.find('#');
      links.push_back(
          {target.substr(0, hash), hash == std::string::npos ? "" : target.substr(hash + 1), number});
    }
  });
  return links;
}

std::vector<std::string> anchors_of(std::string_view markdown) {
  std::vector<std::string> anchors;
  for_each_line_of_text(markdown, [&](const std::string& line, int) {
    const std::size_t begin = line.find_first_not_of('#');
    if (begin == 0 || begin == std::string::npos || line[begin] != ' ') return;
    std::string anchor;
    for (const char c : line.substr(begin + 1)) {
      const auto byte = static_cast<unsigned char>(c);
      if (std::isalnum(byte) || c == '-' || c == '_' || byte >= 0x80)
        anchor += static_cast<char>(std::tolower(byte));
      else if (c == ' ')
        anchor += '-';
    }
    anchors.push_back(anchor);
  });
  return anchors;
}

std::vector<std::string> broken_links(const std::vector<Document>& documents,
                                      const std::function<bool(const std::string&)>& exists) {
  std::map<std::string, std::vector<std::string>> anchors;
  for (const Document& document : documents) anchors[document.path] = anchors_of(document.text);
  std::vector<std::string> broken;
  for (const Document& document : documents)
    for (const DocumentLink& link : links_of(document.text)) {
      const std::string target = resolved(document.path, link.target);
      const auto found = anchors.find(target);
      if (found == anchors.end() && !exists(target))
        broken.push_back(
            text(document.path, ":", link.line, ": links to ", link.target, ", which is not there"));
      else if (!link.heading.empty() && found != anchors.end() &&
               std::find(found->second.begin(), found->second.end(), link.heading) == found->second.end())
        broken.push_back(
            text(document.path, ":", link.line, ": ", target, " has no heading '", link.heading, "'"));
    }
  return broken;
}

}  // namespace floatstage::architecture
