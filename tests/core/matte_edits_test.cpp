#include "core/matte_edits.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

MatteEdits some_edits() {
  CameraEdits camera;
  camera.keyframes.push_back({3,
                              {{MatteLabel::Foreground, 2.5, {{10.5, 20.25}}},
                               {MatteLabel::Background, 4, {{0, 0}, {5, 5}, {9, 1}}}}});
  camera.keyframes.push_back({17, {}});
  camera.masks.push_back({MatteLabel::Background, {{0, 0}, {10, 0}, {10, 8}}, 2, 9});
  camera.masks.push_back({MatteLabel::Foreground, {{1, 1}, {2, 1}, {2, 2}, {1, 2}}, 0, std::nullopt});
  camera.masks.push_back({MatteLabel::Background, {{7.25, 3}}, 4, 4, 6.5});
  return {{{"cam01", camera}, {"cam02", {}}}};
}

int count(const Image& map, int value) {
  return static_cast<int>(std::count(map.pixels.begin(), map.pixels.end(), value));
}

TEST(MatteEdits, ComeBackFromTheirFileAsTheyWere) {
  TempFolder folder;
  ASSERT_THAT(save_matte_edits(some_edits(), folder / "edits.json"), IsOk());
  const Result<MatteEdits> back = load_matte_edits(folder / "edits.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(*back, some_edits());
}

MatteEdits edits_of_two() {
  MatteEdits edits = some_edits();
  edits.cameras["cam01"].keyframes[0].strokes[0].subject = "woman";
  edits.cameras["cam02"].keyframes.push_back({0, {{MatteLabel::Foreground, 3, {{4, 5}}, "man"}}});
  return edits;
}

TEST(MatteEdits, SayWhoseAStrokeIs) {
  TempFolder folder;
  ASSERT_THAT(save_matte_edits(edits_of_two(), folder / "edits.json"), IsOk());
  const Result<MatteEdits> back = load_matte_edits(folder / "edits.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(*back, edits_of_two());
  EXPECT_EQ(without_subjects(back->cameras.at("cam01")), some_edits().cameras.at("cam01"));
}

TEST(MatteEdits, AreOfFormat2OnlyWhereAStrokeIsSomebodys) {
  EXPECT_THAT(to_json(edits_of_two()), testing::HasSubstr("\"floatstage_edits\": 2"));
  const std::string one = to_json(some_edits());
  EXPECT_THAT(one, testing::HasSubstr("\"floatstage_edits\": 1"));
  EXPECT_THAT(one, testing::Not(testing::HasSubstr("subject"))) << "which older programs read";
  std::string two = one;
  two.replace(two.find("edits\": 1"), 9, "edits\": 2");
  const Result<MatteEdits> read = parse_matte_edits(two, "edits.json");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(to_json(*read), one) << "byte by byte";
}

TEST(MatteEdits, AreRefusedCutOffAnywhere) {
  const std::string whole = to_json(edits_of_two());
  for (std::size_t n = 0; n + 2 < whole.size(); ++n)
    EXPECT_THAT(parse_matte_edits(whole.substr(0, n), "edits.json"),
                FailsWith(ErrorCode::BadData, "edits.json"))
        << n;
}

TEST(MatteEdits, AreNoneWhereThereIsNoFile) {
  TempFolder folder;
  EXPECT_THAT(load_matte_edits(folder / "edits.json"), IsOkAnd(MatteEdits()));
}

TEST(MatteEdits, CountAPersonsWork) {
  const MatteEffort effort = effort_of(some_edits().cameras.at("cam01"));
  EXPECT_EQ(effort.keyframes, 2);
  EXPECT_EQ(effort.clicks, 1);
  EXPECT_EQ(effort.scribbles, 1);
  EXPECT_EQ(effort.masks, 3);
}

struct Fault {
  const char* json;
  const char* complaint;
};

TEST(MatteEdits, NameTheCameraAndTheFault) {
  const Fault faults[] = {
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "hair", "points": [[1, 2]]}]}]}}})",
       "hair"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "foreground", "points": []}]}]}}})",
       "at least 1"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyframes": [{"frame": -1, "strokes": []}]}}})",
       "negative"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyframes": [{"frame": 4, "strokes": []}, {"frame": 4, "strokes": []}]}}})",
       "order"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "polygon": [[0, 0], [1, 1]]}]}}})",
       "at least 3"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "polygon": [[0, 0], [1, 1], [1, 1e9]]}]}}})",
       "far outside"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "polygon": [[0, 0], [1, 1], [0, 1]], "first": 5, "last": 4}]}}})",
       "before it begins"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "brush": []}]}}})",
       "at least 1"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "brush": [[0, 0]]}]}}})",
       "radius"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "brush": [[0, 0]], "radius": -1}]}}})",
       "radius"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"masks": [{"label": "background", "brush": [[0, 0]], "radius": 1, "polygon": []}]}}})",
       "polygon"},
      {R"({"floatstage_edits": 2, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "foreground", "points": [[1, 2]], "subject": "../x"}]}]}}})",
       "'../x' cannot be a subject"},
      {R"({"floatstage_edits": 2, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "foreground", "points": [[1, 2]], "subject": ""}]}]}}})",
       "cannot be a subject: letters, digits"},
      {R"({"floatstage_edits": 2, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "foreground", "points": [[1, 2]], "subject": 7}]}]}}})",
       "subject"},
      {R"({"floatstage_edits": 2, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "background", "points": [[1, 2]], "subject": "man"}]}]}}})",
       "the subject 'man' is marked as background"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "foreground", "points": [[1, 2]], "subject": "man"}]}]}}})",
       "unknown key 'subject'"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyfarmes": []}}})", "keyfarmes"},
      {R"({"floatstage_edits": 1, "cameras": {"a": {"keyframes": [{"frame": 1, "strokes": [{"label": "foreground", "radius": 0, "points": [[1, 2]]}]}]}}})",
       "radius"}};
  for (const Fault& fault : faults) {
    EXPECT_THAT(parse_matte_edits(fault.json, "edits.json"), FailsWith(ErrorCode::BadData, fault.complaint));
    EXPECT_THAT(parse_matte_edits(fault.json, "edits.json"), FailsWith(ErrorCode::BadData, "camera 'a'"));
  }
  EXPECT_THAT(parse_matte_edits(R"({"floatstage_edits": 1, "cameras": [)", "edits.json"),
              FailsWith(ErrorCode::BadData, "edits.json"));
  EXPECT_THAT(
      parse_matte_edits(R"({"floatstage_edits": 9, "cameras": {}})", "edits.json"),
      FailsWith(ErrorCode::Unsupported, "format 9 is not known here; this program reads formats 1 and 2"));
}

TEST(PaintStrokes, FillsTheDiscOfAClickAndTheLineOfAScribble) {
  Image map(40, 30, 1, 128);
  paint_strokes({{MatteLabel::Foreground, 5, {{20, 15}}}}, 1, map);
  EXPECT_NEAR(count(map, 255), 3.14159 * 25, 6);
  EXPECT_EQ(*map.at(20, 15), 255);
  paint_strokes({{MatteLabel::Background, 1, {{0, 15}, {40, 15}}}}, 1, map);
  EXPECT_EQ(count(map, 0), 80) << "two rows, over the click";
}

TEST(PaintStrokes, CoverAPixelAtAnyScaleAndNothingOutside) {
  Image map(40, 30, 1, 128);
  paint_strokes({{MatteLabel::Foreground, 0.5, {{200.5, 100.5}}}}, 0.1, map);
  EXPECT_EQ(count(map, 255), 1);
  EXPECT_EQ(*map.at(20, 10), 255);
  paint_strokes({{MatteLabel::Foreground, 3, {{-500, 10}}}, {MatteLabel::Foreground, 3, {{10, 1e6}}}}, 1,
                map);
  EXPECT_EQ(count(map, 255), 1);
}

TEST(PaintMasks, FillsThePolygonInItsFramesOnly) {
  const std::vector<MatteMask> masks = {
      {MatteLabel::Background, {{10, 5}, {20, 5}, {20, 15}, {10, 15}}, 2, 4}};
  for (const int frame : {1, 2, 4, 5}) {
    Image map(40, 30, 1, 128);
    paint_masks(masks, frame, 1, map);
    EXPECT_EQ(count(map, 0), frame == 2 || frame == 4 ? 100 : 0) << frame;
  }
  Image half(20, 15, 1, 128);
  paint_masks(masks, 3, 0.5, half);
  EXPECT_EQ(count(half, 0), 25);
}

TEST(PaintMasks, CutsAPolygonOffAtThePicturesEdge) {
  Image map(10, 10, 1, 128);
  paint_masks({{MatteLabel::Foreground, {{-100, -100}, {100, -100}, {100, 100}, {-100, 100}}, 0, {}}}, 0, 1,
              map);
  EXPECT_EQ(count(map, 255), 100);
}

TEST(PaintMasks, PaintABrushAsItWasDrawn) {
  MatteMask mask{MatteLabel::Background, {{10, 15}, {30, 15}}, 3, 5, 2};
  Image map(40, 30, 1, 128), stroke(40, 30, 1, 128);
  paint_masks({mask}, 2, 1, map);
  EXPECT_EQ(count(map, 0), 0) << "before it begins";
  paint_masks({mask}, 4, 1, map);
  paint_strokes({{MatteLabel::Background, 2, {{10, 15}, {30, 15}}}}, 1, stroke);
  EXPECT_GT(count(map, 0), 80);
  EXPECT_EQ(map, stroke);
}

}  // namespace
}  // namespace floatstage
