#include "tests/architecture_rules.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>
#include <sstream>

#include "core/text.h"

namespace floatstage::architecture {
namespace {

constexpr int kMostLines = 600;
constexpr int kMostColumns = 110;

std::string first_folder(std::string_view path) { return std::string(path.substr(0, path.find('/'))); }

// "core/synthetic" is a layer of its own; every other path belongs to its first folder.
std::string layer_of(std::string_view path) {
  return path.starts_with("core/synthetic/") ? "core/synthetic" : first_folder(path);
}

// The same text with comments blanked and line ends kept. Good enough for include lines: no string literals
// there.
std::string without_comments(std::string_view cpp) {
  std::string out;
  for (std::size_t i = 0; i < cpp.size();) {
    const bool line = cpp.substr(i, 2) == "//", block = cpp.substr(i, 2) == "/*";
    if (!line && !block) {
      out += cpp[i++];
      continue;
    }
    const std::size_t end = std::min(cpp.find(line ? "\n" : "*/", i + 2), cpp.size());
    for (; i < end; ++i)
      if (cpp[i] == '\n') out += '\n';
    if (block) i = std::min(i + 2, cpp.size());
  }
  return out;
}

bool is_standard_or_eigen(const std::string& target) {
  if (target.starts_with("Eigen/")) return true;
  return std::all_of(target.begin(), target.end(),
                     [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '_'; });
}

bool is_cpp(std::string_view path) { return path.ends_with(".h") || path.ends_with(".cpp"); }

// The floors above the stages. They share the stages, and know nothing of one another but what lies below.
bool is_floor(const std::string& layer) {
  return layer == "pipeline" || layer == "studio" || layer == "apps";
}

// Why `from` must not include `target`, or nothing.
std::string layering_fault(const std::string& from, const std::string& target,
                           const std::set<std::string>& public_headers) {
  const std::string here = layer_of(from), there = layer_of(target);
  const bool known = stages().contains(there) || there == "core" || there == "core/synthetic" ||
                     is_floor(there) || there == "tests";
  if (!known || here == there || here == "tests") return "";
  if (there == "tests") return "the product must not include tests";
  if (there == "apps") return "apps is the top floor: nothing below includes it";
  if (is_floor(there)) return here == "apps" ? "" : there + " is above the stages, beside the other floor";
  if (there == "core/synthetic") {
    if (is_floor(here) || from.starts_with("capture/synthetic")) return "";
    return "core/synthetic is for pipeline, studio, apps, tests and capture's synthetic source alone";
  }
  if (is_floor(here) && stages().contains(there) && !public_headers.contains(target))
    return here + " includes a header that docs/architecture.md does not name as public";
  if (!is_floor(here) && stages().contains(there))
    return here.starts_with("core") ? "core must not include a stage"
                                    : "a stage must not include another stage";
  return "";
}

std::string folder_of(std::string_view path) { return std::string(path.substr(0, path.rfind('/'))); }

// The rank of each folder inside the floors: it may include those of a lower rank, and no other of its own.
const std::map<std::string, int>& ranks() {
  static const std::map<std::string, int> table = {{"pipeline/metrics", 0},   {"pipeline", 1},
                                                   {"pipeline/import", 2},    {"pipeline/derive", 2},
                                                   {"pipeline/export", 2},    {"pipeline/silhouettes", 2},
                                                   {"pipeline/matte", 3},     {"pipeline/stills", 3},
                                                   {"pipeline/process", 4},   {"pipeline/calibrate", 4},
                                                   {"pipeline/evaluate", 4},  {"pipeline/demo", 5},
                                                   {"pipeline/plan", 5},      {"pipeline/reproduce", 5},
                                                   {"studio/messages", 0},    {"studio/network", 1},
                                                   {"studio/page", 1},        {"studio/node", 2},
                                                   {"studio/live", 3},        {"apps/check", 0},
                                                   {"apps/terminal", 0},      {"apps/viewer/window", 0},
                                                   {"apps/viewer/mattes", 1}, {"apps/viewer/play", 2},
                                                   {"apps/viewer/live", 3},   {"apps/viewer/calibration", 3},
                                                   {"apps/viewer/detail", 3}, {"apps/calibrate", 4},
                                                   {"apps/detail", 4},        {"apps/evaluate", 4},
                                                   {"apps/export", 4},        {"apps/live", 4},
                                                   {"apps/plan", 4},          {"apps/take", 4},
                                                   {"apps/matte", 5},         {"apps", 6},
                                                   {"apps/manual", 7}};
  return table;
}

// Why a file of a floor must not include another of the same floor, or nothing.
std::string rank_fault(const std::string& from, const std::string& target) {
  const std::string here = folder_of(from), there = folder_of(target);
  if (here == there || first_folder(here) != first_folder(there)) return "";
  for (const std::string& folder : {here, there})
    if (!ranks().contains(folder)) return folder + " has no rank; give it one in architecture_rules.cpp";
  return ranks().at(there) < ranks().at(here) ? "" : there + " is not below " + here;
}

bool is_inside(const std::string& folder, const std::string& other) {
  return folder.starts_with(other + "/");
}

bool is_of_the_user_interface(const std::string& target) {
  return target.starts_with("CLI/") || target.starts_with("GLFW/") || target.starts_with("imgui");
}

using Graph = std::map<std::string, std::map<std::string, std::string>>;  // folder → folder, and a place

// A way from `at` back to `goal`, depth first, or nothing.
bool find_way(const Graph& graph, const std::string& at, const std::string& goal, std::set<std::string>& seen,
              std::vector<std::string>& way) {
  const auto edges = graph.find(at);
  if (edges == graph.end()) return false;
  for (const auto& [next, place] : edges->second) {
    way.push_back(place);
    if (next == goal || (seen.insert(next).second && find_way(graph, next, goal, seen, way))) return true;
    way.pop_back();
  }
  return false;
}

}  // namespace

const std::set<std::string>& stages() {
  static const std::set<std::string> names = {"capture", "calib", "matting", "recon", "render", "detail"};
  return names;
}

std::vector<Include> includes_of(std::string_view cpp) {
  std::vector<Include> found;
  std::istringstream lines(without_comments(cpp));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::string packed;
    std::remove_copy_if(line.begin(), line.end(), std::back_inserter(packed),
                        [](unsigned char c) { return std::isspace(c); });
    const std::string_view directive = "#include";
    if (!packed.starts_with(directive) || packed.size() < directive.size() + 2) continue;
    const bool angled = packed[directive.size()] == '<';
    const std::size_t end = packed.find(angled ? '>' : '"', directive.size() + 1);
    if (end != std::string::npos)
      found.push_back({packed.substr(directive.size() + 1, end - directive.size() - 1), angled, number});
  }
  return found;
}

std::set<std::string> public_headers(std::string_view architecture_md) {
  std::set<std::string> headers;
  std::istringstream lines{std::string(architecture_md)};
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(cell);
    // | `core/` | in and out | `time frame …` | …
    if (cells.size() < 4) continue;
    const std::size_t begin = cells[1].find('`'), end = cells[1].find("/`");
    if (begin == std::string::npos || end == std::string::npos) continue;
    const std::string folder = cells[1].substr(begin + 1, end - begin);
    std::string names = cells[3];
    std::replace(names.begin(), names.end(), '`', ' ');
    std::istringstream words(names);
    for (std::string name; words >> name;) headers.insert(folder + name + ".h");
  }
  return headers;
}

std::vector<std::string> breaches_of_layering(const std::vector<SourceFile>& files,
                                              const std::set<std::string>& headers) {
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (!is_cpp(file.path)) continue;
    for (const Include& include : includes_of(file.text))
      if (const std::string fault = layering_fault(file.path, include.target, headers); !fault.empty())
        breaches.push_back(text(file.path, ":", include.line, ": includes ", include.target, ": ", fault));
  }
  return breaches;
}

std::vector<std::string> breaches_of_ranks(const std::vector<SourceFile>& files) {
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (!is_cpp(file.path) || !is_floor(first_folder(file.path))) continue;
    for (const Include& include : includes_of(file.text))
      if (const std::string fault = rank_fault(file.path, include.target); !fault.empty())
        breaches.push_back(text(file.path, ":", include.line, ": includes ", include.target, ": ", fault));
  }
  return breaches;
}

std::vector<std::string> breaches_of_user_interface(const std::vector<SourceFile>& files) {
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    const std::string top = first_folder(file.path);
    if (!is_cpp(file.path) || top == "apps" || top == "tests") continue;
    for (const Include& include : includes_of(file.text))
      if (is_of_the_user_interface(include.target))
        breaches.push_back(text(file.path, ":", include.line, ": includes ", include.target,
                                ": command line and windows are of apps alone"));
  }
  return breaches;
}

std::vector<std::string> breaches_of_folder_cycles(const std::vector<SourceFile>& files) {
  std::set<std::string> paths;
  for (const SourceFile& file : files) paths.insert(file.path);
  Graph graph;
  for (const SourceFile& file : files) {
    if (!is_cpp(file.path) || first_folder(file.path) == "tests") continue;
    for (const Include& include : includes_of(file.text)) {
      const std::string here = folder_of(file.path), there = folder_of(include.target);
      if (here == there || !paths.contains(include.target)) continue;
      // A stage's own folder is its contract and its composition: its rooms know it, and it knows them.
      const bool of_a_stage = !is_floor(first_folder(here));
      if (of_a_stage && (is_inside(here, there) || is_inside(there, here))) continue;
      graph[here].emplace(there, text(file.path, ":", include.line, " includes ", include.target));
    }
  }
  std::vector<std::string> breaches;
  std::set<std::string> told;
  for (const auto& [folder, edges] : graph) {
    std::set<std::string> seen;
    std::vector<std::string> way;
    if (told.contains(folder) || !find_way(graph, folder, folder, seen, way)) continue;
    std::string sentence = "folders include each other:";
    for (const std::string& place : way) {
      sentence += text(" ", place, ";");
      told.insert(folder_of(place.substr(0, place.find(':'))));
    }
    breaches.push_back(sentence);
  }
  return breaches;
}

std::vector<std::string> breaches_of_public_headers(const std::vector<SourceFile>& files,
                                                    const std::set<std::string>& headers) {
  std::map<std::string, const SourceFile*> by_path;
  for (const SourceFile& file : files) by_path[file.path] = &file;
  std::vector<std::string> breaches;
  std::set<std::string> seen = headers;
  std::vector<std::string> waiting(headers.begin(), headers.end());
  while (!waiting.empty()) {
    const std::string path = waiting.back();
    waiting.pop_back();
    const auto file = by_path.find(path);
    if (file == by_path.end()) {
      breaches.push_back(path + ": docs/architecture.md names this header, and it is not there");
      continue;
    }
    for (const Include& include : includes_of(file->second->text)) {
      const bool ours = !include.angled && by_path.contains(include.target);
      if (ours && seen.insert(include.target).second) waiting.push_back(include.target);
      if (!ours && !(include.angled && is_standard_or_eigen(include.target)))
        breaches.push_back(text(path, ":", include.line, ": includes ", include.target,
                                ": a public header names only the standard library, Eigen and our headers"));
    }
  }
  std::sort(breaches.begin(), breaches.end());
  return breaches;
}

std::vector<std::string> breaches_of_folder_names(const std::vector<std::string>& folders) {
  const std::set<std::string> refused = {"util", "utils", "common", "include", "third_party"};
  std::vector<std::string> breaches;
  for (const std::string& folder : folders)
    if (refused.contains(folder.substr(folder.rfind('/') + 1)))
      breaches.push_back(folder + ": a folder of this name says nothing of what is in it");
  return breaches;
}

std::vector<std::string> breaches_of_length(const std::vector<SourceFile>& files) {
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    const auto lines = std::count(file.text.begin(), file.text.end(), '\n');
    if (lines > kMostLines)
      breaches.push_back(text(file.path, ": ", lines, " lines; cut it into ideas of at most ", kMostLines));
  }
  return breaches;
}

std::vector<std::string> breaches_of_width(const std::vector<SourceFile>& files) {
  static const std::regex raw_begins(R"re(R"([A-Za-z_]*)\()re");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (!is_cpp(file.path)) continue;
    std::istringstream lines(file.text);
    std::string raw_end;  // what closes the raw string that a line lies in
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      std::smatch begin;
      const bool begins = raw_end.empty() && std::regex_search(line, begin, raw_begins);
      if (begins) raw_end = ")" + begin[1].str() + "\"";
      const bool raw = !raw_end.empty();
      if (raw && line.find(raw_end, begins ? begin.position() + begin.length() : 0) != line.npos)
        raw_end.clear();
      const auto columns = std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      if (!raw && columns > kMostColumns)
        breaches.push_back(text(file.path, ":", number, ": ", columns, " columns; at most ", kMostColumns));
    }
  }
  return breaches;
}

std::vector<std::string> breaches_of_opencv_threads(const std::vector<SourceFile>& files) {
  static const std::regex constant(R"(^(inline|\[\[maybe_unused\]\]) const bool \w+ = )");
  std::vector<std::string> breaches;
  for (const SourceFile& file : files) {
    if (!is_cpp(file.path) || file.path.starts_with("tests/")) continue;
    std::istringstream lines(file.text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      if (line.find("setNumThreads") != line.npos && !std::regex_search(line, constant))
        breaches.push_back(
            text(file.path, ":", number, ": sets OpenCV's threads while others may work in them"));
    }
  }
  return breaches;
}

}  // namespace floatstage::architecture
