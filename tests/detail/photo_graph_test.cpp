// Parents from given relations: every rule on a table made for it.

#include "detail/photo_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "detail/graph_json.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

/// Relations of photographs of 1000 x 1000 px, of which none has to do with another until it is said.
PhotoRelations unrelated(const std::vector<std::string>& names) {
  PhotoRelations r;
  for (const std::string& name : names) r.photos.push_back({name, "hash of " + name, 1000, 1000, 500});
  r.pairs.resize(names.size() * names.size());
  for (PairRelation& pair : r.pairs) pair.why = "3 features agree, at least 10 are wanted";
  return r;
}

void contain(PhotoRelations& r, std::size_t child, std::size_t parent, double zoom) {
  PairRelation pair;
  pair.matches = pair.inliers = 50;
  pair.zoom = zoom;
  pair.inside = 1;
  pair.parent_from_child = Eigen::DiagonalMatrix<double, 3>(1 / zoom, 1 / zoom, 1);
  r.pairs[child * r.photos.size() + parent] = pair;
}

std::string reason(const PhotoGraph& graph, const std::string& child, const std::string& parent) {
  for (const Refusal& refusal : graph.refused)
    if (refusal.child == child && refusal.parent == parent) return refusal.why;
  return "not refused";
}

std::vector<int> parents(const PhotoGraph& graph) {
  std::vector<int> out;
  for (const GraphPhoto& photo : graph.photos) out.push_back(photo.parent);
  return out;
}

TEST(PhotoGraph, MakesAChildOfWhereItIsLargest) {
  PhotoRelations r = unrelated({"close", "middle", "wide"});
  contain(r, 0, 1, 2);
  contain(r, 0, 2, 4);
  contain(r, 1, 2, 2);
  const Result<PhotoGraph> graph = choose_parents(r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(parents(*graph), testing::ElementsAre(1, 2, -1));
  EXPECT_EQ(graph->root, 2) << "the most lie below it";
  EXPECT_THAT(graph->descendants(2), testing::ElementsAre(1, 0));
  EXPECT_EQ(reason(*graph, "close", "wide"), "larger in middle");
  EXPECT_EQ(reason(*graph, "wide", "close"), "3 features agree, at least 10 are wanted");
}

TEST(PhotoGraph, HasAReasonForEveryPairThatIsNoEdge) {
  PhotoRelations r = unrelated({"a", "b", "c", "d"});
  contain(r, 0, 1, 2);
  const Result<PhotoGraph> graph = choose_parents(r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_EQ(graph->refused.size(), 4u * 3 - 1);
  for (const Refusal& refusal : graph->refused) EXPECT_FALSE(refusal.why.empty());
}

TEST(PhotoGraph, DropsAPhotographThatIsNoSharperThanItsParentAndKeepsItsChildren) {
  PhotoRelations r = unrelated({"close", "coarse", "wide"});
  r.photos[1].width = r.photos[1].height = 250;
  contain(r, 0, 1, 4);
  contain(r, 1, 2, 0.5);
  contain(r, 0, 2, 2);
  const Result<PhotoGraph> graph = choose_parents(r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(parents(*graph), testing::ElementsAre(2, -1, -1));
  EXPECT_EQ(reason(*graph, "coarse", "wide"), "shows no more of it: zoom 0.5");
}

TEST(PhotoGraph, KeepsOneOfTwoCopies) {
  PhotoRelations r = unrelated({"close", "copy", "wide", "wide again"});
  contain(r, 0, 2, 2);
  contain(r, 0, 3, 2);
  contain(r, 2, 3, 1);
  contain(r, 3, 2, 1);
  contain(r, 1, 0, 1);
  contain(r, 0, 1, 1);
  contain(r, 1, 2, 2);
  const Result<PhotoGraph> graph = choose_parents(r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(parents(*graph), testing::ElementsAre(2, -1, -1, -1));
  EXPECT_EQ(reason(*graph, "wide again", "wide"), "the same picture as wide");
  EXPECT_EQ(reason(*graph, "close", "wide again"), "it is the same picture as wide");
  EXPECT_EQ(reason(*graph, "copy", "wide"), "the same picture as close");
}

TEST(PhotoGraph, TakesALargerScanOfAPhotographAsItsDetail) {
  PhotoRelations r = unrelated({"original", "small"});
  contain(r, 0, 1, 4);
  contain(r, 1, 0, 0.25);
  const Result<PhotoGraph> graph = choose_parents(r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(parents(*graph), testing::ElementsAre(1, -1));
}

TEST(PhotoGraph, CutsACircleWhereItsZoomIsLeast) {
  PhotoRelations r = unrelated({"a", "b", "c"});
  contain(r, 0, 1, 1.05);
  contain(r, 1, 2, 1.02);
  contain(r, 2, 0, 1.04);
  const Result<PhotoGraph> graph = choose_parents(r, "");
  ASSERT_THAT(graph, IsOk());
  EXPECT_THAT(parents(*graph), testing::ElementsAre(1, -1, 0));
  EXPECT_EQ(reason(*graph, "b", "c"), "would be its own ancestor");
}

TEST(PhotoGraph, TakesTheRootThatOneAsksFor) {
  PhotoRelations r = unrelated({"a", "b"});
  EXPECT_EQ(choose_parents(r, "b")->root, 1);
  EXPECT_THAT(choose_parents(r, "bee"), FailsWith(ErrorCode::InvalidArgument, "--root bee"));
}

TEST(GraphFile, GivesBackTheGraphAndFindsItsPhotographsWhereverItLies) {
  PhotoRelations r = unrelated({"close \"up\"", "wide"});
  contain(r, 0, 1, 3.0 / 7);
  contain(r, 0, 1, 7.0 / 3);
  PhotoGraph graph = *choose_parents(r, "");
  const TempFolder folder;
  graph.folder = folder / "photos";
  graph.unread = {{"bad.jpg", "bad.jpg is empty"}};
  ASSERT_THAT(save_graph(graph, folder / "graph.json"), IsOk());
  const Result<PhotoGraph> back = load_graph(folder / "graph.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->folder, graph.folder);
  EXPECT_EQ(back->root, 1);
  EXPECT_EQ(back->photos[0].parent, 1);
  EXPECT_EQ(back->photos[0].parent_from_child, graph.photos[0].parent_from_child);
  EXPECT_EQ(back->photos[0].zoom, 7.0 / 3);
  EXPECT_EQ(back->refused.size(), graph.refused.size());
  EXPECT_EQ(back->unread[0].why, "bad.jpg is empty");
  EXPECT_EQ(graph_to_json(*back, folder.path()), graph_to_json(graph, folder.path()));
}

std::string with(const std::string& json, const std::string& from, const std::string& to) {
  const std::size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return std::string(json).replace(at, from.size(), to);
}

TEST(GraphFile, IsRefusedWhereItMakesNoSense) {
  PhotoRelations r = unrelated({"close", "wide"});
  contain(r, 0, 1, 2);
  const std::string json = graph_to_json(*choose_parents(r, ""), ".");
  const auto read = [](const std::string& text) { return graph_from_json(text, "g.json", "."); };
  ASSERT_THAT(read(json), IsOk());
  EXPECT_THAT(read(with(json, "\"name\": \"close\"", "\"name\": \"../close\"")),
              FailsWith(ErrorCode::BadData, "leads out of the folder"));
  EXPECT_THAT(read(with(json, "\"parent\": \"wide\"", "\"parent\": \"close\"")),
              FailsWith(ErrorCode::BadData, "its own ancestor"));
  EXPECT_THAT(read(with(json, "\"parent\": \"wide\"", "\"parent\": \"far\"")),
              FailsWith(ErrorCode::BadData, "no photograph far"));
  EXPECT_THAT(read(with(json, "\"root\": \"wide\"", "\"root\": \"far\"")),
              FailsWith(ErrorCode::BadData, "root"));
  EXPECT_THAT(read(with(json, "\"width\": 1000", "\"width\": 0")), FailsWith(ErrorCode::BadData, "size"));
  EXPECT_THAT(read(with(json, "floatstage-photo-graph", "other")),
              FailsWith(ErrorCode::BadData, "no photo graph"));
  EXPECT_THAT(read(json.substr(0, json.size() / 2)), FailsWith(ErrorCode::BadData, "g.json"));
  EXPECT_THAT(read(std::string(40, '[')), FailsWith(ErrorCode::BadData, "deeper"));
}

TEST(GraphFile, ForGraphvizShowsEdgesAndNearMisses) {
  PhotoRelations r = unrelated({"a\"b", "wide", "beside"});
  contain(r, 0, 1, 2);
  r.pairs[2 * 3 + 1].why = "reaches beyond it: 80 % lie inside";
  const std::string dot = graph_to_dot(*choose_parents(r, ""));
  EXPECT_THAT(dot, testing::HasSubstr("\"wide\" -> \"a\\\"b\" [label=\"2.00 x, 50\"]"));
  EXPECT_THAT(dot,
              testing::HasSubstr(
                  "\"wide\" -> \"beside\" [label=\"reaches beyond it: 80 % lie inside\", style=dotted]"));
  EXPECT_THAT(dot, testing::Not(testing::HasSubstr("features agree")));
}

}  // namespace
}  // namespace floatstage::detail
