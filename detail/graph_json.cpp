#include "detail/graph_json.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"
#include "detail/quad.h"

namespace floatstage::detail {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr std::size_t kLongest = 64 << 20;
constexpr int kMostSide = 1 << 20;

Json json_of(const PhotoGraph& graph, const GraphPhoto& p) {
  Json j = {{"name", p.photo.name},   {"parent", nullptr},        {"zoom", nullptr},
            {"homography", nullptr},  {"inliers", p.inliers},     {"rms", p.rms},
            {"width", p.photo.width}, {"height", p.photo.height}, {"features", p.photo.features},
            {"hash", p.photo.hash}};
  if (p.parent < 0) return j;
  j["parent"] = graph.photos[static_cast<std::size_t>(p.parent)].photo.name;
  j["zoom"] = p.zoom;
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r)
    rows.push_back({p.parent_from_child(r, 0), p.parent_from_child(r, 1), p.parent_from_child(r, 2)});
  j["homography"] = rows;
  return j;
}

bool is_null(const nlohmann::json* value) { return value == nullptr || value->is_null(); }

// The photograph, and its parent's name.
std::pair<GraphPhoto, std::string> photo_of(JsonFields& j) {
  GraphPhoto p;
  std::string parent;
  p.photo.name = j.string("name");
  p.inliers = j.integer("inliers");
  p.rms = j.number("rms");
  p.photo.width = j.integer("width");
  p.photo.height = j.integer("height");
  p.photo.features = j.integer("features");
  p.photo.hash = j.string("hash");
  if (is_null(j.child("parent"))) {
    j.child("zoom");
    j.child("homography");
    return {p, parent};
  }
  parent = j.string("parent");
  p.zoom = j.number("zoom");
  const std::vector<double> h = j.numbers("homography", 9);
  for (int i = 0; i < 9; ++i) p.parent_from_child(i / 3, i % 3) = h[static_cast<std::size_t>(i)];
  return {p, parent};
}

// What of names a program may open: below the folder, never above it.
bool is_inside(const std::string& name) {
  const fs::path path(name);
  return !name.empty() && path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

std::string fault_of(const GraphPhoto& p, bool has_parent) {
  if (!is_inside(p.photo.name)) return "a photograph's name leads out of the folder";
  if (p.photo.width < 1 || p.photo.height < 1 || p.photo.width > kMostSide || p.photo.height > kMostSide)
    return "a size that no photograph has";
  if (has_parent && !(p.zoom > 0 && p.zoom < kMostSide)) return "a zoom that cannot be";
  if (has_parent && !sane_quad(p.parent_from_child, p.photo.width, p.photo.height))
    return "a homography that folds the photograph";
  return "";
}

// Sets parents from their names; what is wrong with them, or nothing.
std::string connect(PhotoGraph& graph, const std::vector<std::string>& parents) {
  std::map<std::string, int> place;
  for (std::size_t i = 0; i < graph.photos.size(); ++i)
    if (!place.emplace(graph.photos[i].photo.name, static_cast<int>(i)).second)
      return text("two photographs are called ", graph.photos[i].photo.name);
  for (std::size_t i = 0; i < parents.size(); ++i) {
    if (parents[i].empty()) continue;
    const auto parent = place.find(parents[i]);
    if (parent == place.end()) return text("there is no photograph ", parents[i]);
    graph.photos[i].parent = parent->second;
  }
  for (std::size_t i = 0; i < graph.photos.size(); ++i) {
    std::size_t steps = 0;
    for (int at = graph.photos[i].parent; at >= 0; at = graph.photos[static_cast<std::size_t>(at)].parent)
      if (++steps > graph.photos.size()) return text(graph.photos[i].photo.name, " is its own ancestor");
  }
  return "";
}

std::string quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

}  // namespace

std::string graph_to_json(const PhotoGraph& graph, const fs::path& folder_of_document) {
  std::error_code error;
  fs::path folder = fs::proximate(graph.folder, folder_of_document.empty() ? "." : folder_of_document, error);
  if (error || folder.empty()) folder = graph.folder;
  Json photos = Json::array(), refused = Json::array(), unread = Json::array();
  for (const GraphPhoto& p : graph.photos) photos.push_back(json_of(graph, p));
  for (const Refusal& r : graph.refused)
    refused.push_back({{"child", r.child}, {"parent", r.parent}, {"why", r.why}});
  for (const UnreadPhoto& u : graph.unread) unread.push_back({{"name", u.name}, {"why", u.why}});
  const std::string root =
      graph.root < 0 ? "" : graph.photos[static_cast<std::size_t>(graph.root)].photo.name;
  return print_json({{"format", "floatstage-photo-graph"},
                     {"version", kVersion},
                     {"folder", folder.generic_string()},
                     {"root", root},
                     {"photos", photos},
                     {"refused", refused},
                     {"unread", unread}});
}

Result<PhotoGraph> graph_from_json(std::string_view json, std::string_view name,
                                   const fs::path& folder_of_document) {
  const Result<nlohmann::json> parsed = parse_json(json, name, kLongest);
  if (!parsed) return forward(parsed);
  JsonProblem problem;
  JsonFields document(*parsed, std::string(name), problem);
  if (document.string("format") != "floatstage-photo-graph" || document.integer("version") != kVersion)
    problem.note(std::string(name), "no photo graph of this version; `floatstage detail graph` makes one");
  PhotoGraph graph;
  const std::string root = document.string("root");
  const fs::path folder = document.string("folder");
  graph.folder = folder.is_absolute() ? folder : (folder_of_document / folder).lexically_normal();
  std::vector<std::string> parents;
  const auto each = [&](const char* key, const auto& take) {
    const nlohmann::json* list = document.list(key);
    for (std::size_t i = 0; list != nullptr && i < list->size() && !problem.first; ++i) {
      JsonFields fields((*list)[i], text(name, ": ", key, " ", i), problem);
      take(fields);
      fields.refuse_others();
    }
  };
  each("photos", [&](JsonFields& fields) {
    auto [photo, parent] = photo_of(fields);
    if (const std::string fault = fault_of(photo, !parent.empty()); !fault.empty() && !problem.first)
      problem.note(fields.where(), fault);
    graph.photos.push_back(std::move(photo));
    parents.push_back(std::move(parent));
  });
  each("refused", [&](JsonFields& fields) {
    graph.refused.push_back({fields.string("child"), fields.string("parent"), fields.string("why")});
  });
  each("unread", [&](JsonFields& fields) {
    graph.unread.push_back({fields.string("name"), fields.string("why")});
  });
  document.refuse_others();
  if (!problem.first)
    if (const std::string fault = connect(graph, parents); !fault.empty())
      problem.note(std::string(name), fault);
  for (std::size_t i = 0; i < graph.photos.size(); ++i)
    if (graph.photos[i].photo.name == root) graph.root = static_cast<int>(i);
  if (graph.root < 0 && !problem.first)
    problem.note(std::string(name), text("there is no root '", root, "'"));
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return graph;
}

Result<PhotoGraph> load_graph(const fs::path& file) {
  const Result<std::string> json = read_file(file);
  if (!json) return forward(json);
  return graph_from_json(*json, file.string(), file.parent_path());
}

Result<void> save_graph(const PhotoGraph& graph, const fs::path& file) {
  return write_file(file, graph_to_json(graph, file.parent_path()));
}

std::string graph_to_dot(const PhotoGraph& graph) {
  std::string out = "digraph details {\n  rankdir=TB;\n  node [shape=box];\n";
  const auto edge = [&](const std::string& from, const std::string& to, const std::string& label,
                        const char* more) {
    out += text("  ", quoted(from), " -> ", quoted(to), " [label=", quoted(label), more, "];\n");
  };
  for (const GraphPhoto& p : graph.photos) {
    const bool is_root = graph.root >= 0 && &p == &graph.photos[static_cast<std::size_t>(graph.root)];
    out += text("  ", quoted(p.photo.name), is_root ? " [style=bold]" : "", ";\n");
  }
  for (const GraphPhoto& p : graph.photos) {
    if (p.parent < 0) continue;
    char label[64];
    std::snprintf(label, sizeof label, "%.2f x, %d", p.zoom, p.inliers);
    edge(graph.photos[static_cast<std::size_t>(p.parent)].photo.name, p.photo.name, label, "");
  }
  // Every pair has its reason in the JSON; here those that share enough to be worth a look.
  for (const Refusal& r : graph.refused)
    if (r.why.find("features agree") == std::string::npos) edge(r.parent, r.child, r.why, ", style=dotted");
  return out + "}\n";
}

}  // namespace floatstage::detail
