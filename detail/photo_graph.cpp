// The dependency graph: M. Eisemann, "Error-Concealed Image-Based Rendering", section 4.2. Differs: copies of
// one photograph are found and kept once, and circles, which measured zooms can close, are cut (ADR 0214).

#include "detail/photo_graph.h"

#include <algorithm>
#include <set>

#include "core/text.h"
#include "detail/quad.h"

namespace floatstage::detail {
namespace {

// A zoom is measured from corners that are off by a pixel or so: as good as none.
constexpr double kLeastZoom = 1.01;

/// The graph while parents are chosen.
class Choice {
 public:
  explicit Choice(const PhotoRelations& relations) : r_(relations), n_(r_.photos.size()), why_(n_ * n_) {
    for (const Photo& photo : r_.photos) graph_.photos.push_back({photo, -1, 0, {}, 0, 0});
    for (GraphPhoto& photo : graph_.photos) photo.parent_from_child.setIdentity();
    removed_.assign(n_, false);
    for (std::size_t c = 0; c < n_; ++c)
      for (std::size_t p = 0; p < n_; ++p) why_[c * n_ + p] = r_.pair(c, p).why;
  }

  PhotoGraph made() {
    drop_copies();
    drop_what_brings_nothing();
    for (std::size_t c = 0; c < n_; ++c)
      if (!removed_[c]) take_best(c);
    cut_circles();
    for (std::size_t c = 0; c < n_; ++c)
      for (std::size_t p = 0; p < n_; ++p)
        if (c != p && graph_.photos[c].parent != static_cast<int>(p))
          graph_.refused.push_back({name(c), name(p), reason(c, p)});
    return std::move(graph_);
  }

 private:
  const std::string& name(std::size_t i) const { return r_.photos[i].name; }
  double pixels(std::size_t i) const { return static_cast<double>(r_.photos[i].width) * r_.photos[i].height; }

  // Of two that show the same at the same size, the one with fewer pixels goes; of equals the later one.
  void drop_copies() {
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = a + 1; b < n_; ++b) {
        const PairRelation &there = r_.pair(a, b), &back = r_.pair(b, a);
        if (removed_[a] || removed_[b] || !there.contained() || !back.contained() ||
            there.zoom > kLeastZoom || back.zoom > kLeastZoom)
          continue;
        const bool later = pixels(a) >= pixels(b);
        const std::size_t gone = later ? b : a, kept = later ? a : b;
        removed_[gone] = true;
        copy_of_.emplace_back(gone, kept);
      }
  }

  // The parent in which a child is largest, among those that are there and show it smaller by more than
  // `zoom`.
  int best_parent(std::size_t c, double zoom) const {
    int best = -1;
    double largest = 0;
    for (std::size_t p = 0; p < n_; ++p) {
      const PairRelation& pair = r_.pair(c, p);
      if (p == c || removed_[p] || !pair.contained() || pair.zoom <= zoom) continue;
      const double area = pixels(c) / (pair.zoom * pair.zoom);
      if (area > largest) largest = area, best = static_cast<int>(p);
    }
    return best;
  }

  // A photograph that has no more pixels than its parent has there adds nothing to it, nor to those above.
  // Removing one changes what is best for its children alone, never what it would itself be compared with.
  void drop_what_brings_nothing() {
    std::vector<std::size_t> idle;
    for (std::size_t c = 0; c < n_; ++c) {
      if (removed_[c]) continue;
      const int p = best_parent(c, 0);
      // Each may lie in the other: a shrunk copy lies in its original, which is a detail of it.
      if (p >= 0 && r_.pair(c, static_cast<std::size_t>(p)).zoom <= kLeastZoom && !holds(c, p))
        idle.push_back(c);
    }
    for (const std::size_t c : idle) removed_[c] = true;
  }
  bool holds(std::size_t c, int p) const { return r_.pair(static_cast<std::size_t>(p), c).contained(); }

  void take_best(std::size_t c) {
    const int best = best_parent(c, kLeastZoom);
    if (best < 0) return;
    const PairRelation& pair = r_.pair(c, static_cast<std::size_t>(best));
    GraphPhoto& photo = graph_.photos[c];
    photo.parent = best;
    photo.zoom = pair.zoom;
    photo.parent_from_child = pair.parent_from_child;
    photo.inliers = pair.inliers;
    photo.rms = pair.rms;
  }

  // Zooms around a circle multiply to one, so that one of them is measured wrongly: the least.
  void cut_circles() {
    for (std::size_t start = 0; start < n_; ++start) {
      std::vector<int> way;
      for (int at = static_cast<int>(start); at >= 0;
           at = graph_.photos[static_cast<std::size_t>(at)].parent) {
        const auto met = std::find(way.begin(), way.end(), at);
        if (met == way.end()) {
          way.push_back(at);
          continue;
        }
        const int weakest = *std::min_element(met, way.end(), [&](int a, int b) {
          return graph_.photos[static_cast<std::size_t>(a)].zoom <
                 graph_.photos[static_cast<std::size_t>(b)].zoom;
        });
        GraphPhoto& photo = graph_.photos[static_cast<std::size_t>(weakest)];
        why_[static_cast<std::size_t>(weakest) * n_ + static_cast<std::size_t>(photo.parent)] =
            "would be its own ancestor";
        photo = {photo.photo, -1, 0, Eigen::Matrix3d::Identity(), 0, 0};
        break;
      }
    }
  }

  std::string reason(std::size_t c, std::size_t p) const {
    if (const std::string& why = why_[c * n_ + p]; !why.empty()) return why;
    for (const auto& [gone, kept] : copy_of_) {
      if (gone == c) return text("the same picture as ", name(kept));
      if (gone == p) return text("it is the same picture as ", name(kept));
    }
    const PairRelation& pair = r_.pair(c, p);
    if (pair.zoom <= kLeastZoom) return text("shows no more of it: zoom ", pair.zoom);
    if (removed_[c]) return "shows no more than another photograph does";
    if (removed_[p]) return "it shows no more than another photograph does";
    const int chosen = graph_.photos[c].parent;
    return chosen < 0 ? "none" : text("larger in ", name(static_cast<std::size_t>(chosen)));
  }

  const PhotoRelations& r_;
  const std::size_t n_;
  std::vector<std::string> why_;
  std::vector<bool> removed_;
  std::vector<std::pair<std::size_t, std::size_t>> copy_of_;  // the one that goes, the one that stays
  PhotoGraph graph_;
};

}  // namespace

std::vector<int> PhotoGraph::descendants(int photo) const {
  std::vector<int> found = {photo};
  for (std::size_t next = 0; next < found.size(); ++next)
    for (std::size_t i = 0; i < photos.size(); ++i)
      if (photos[i].parent == found[next]) found.push_back(static_cast<int>(i));
  found.erase(found.begin());
  return found;
}

Result<PhotoGraph> choose_parents(const PhotoRelations& relations, const std::string& root) {
  PhotoGraph graph = Choice(relations).made();
  graph.unread = relations.unread;
  std::size_t most = 0;
  for (int i = 0; i < static_cast<int>(graph.photos.size()); ++i) {
    const std::size_t below = graph.descendants(i).size();
    const bool named = graph.photos[static_cast<std::size_t>(i)].photo.name == root;
    if (root.empty() ? graph.root < 0 || below > most : named) {
      graph.root = i;
      most = below;
    }
  }
  if (graph.root >= 0) return graph;
  return fail(ErrorCode::InvalidArgument,
              text("--root ", root, ": no photograph of this name was read; there is ",
                   relations.photos.front().name, " and ", relations.photos.size() - 1, " others"));
}

Result<PhotoGraph> build_photo_graph(const std::filesystem::path& folder, const GraphOptions& options) {
  const Result<PhotoRelations> relations = relate_photos(folder, options.relations);
  if (!relations) return forward(relations);
  Result<PhotoGraph> graph = choose_parents(*relations, options.root);
  if (graph) graph->folder = folder;
  return graph;
}

}  // namespace floatstage::detail
