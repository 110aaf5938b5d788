#include "apps/evaluate/score_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/text.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;

struct Column {
  const char* name;
  double pipeline::Scores::*score;
};
constexpr Column kColumns[] = {{"psnr_mask", &pipeline::Scores::psnr},
                               {"ssim_mask", &pipeline::Scores::ssim},
                               {"cw_ssim_mask", &pipeline::Scores::cw_ssim},
                               {"psnr_shift_mask", &pipeline::Scores::psnr_shift},
                               {"sharpness", &pipeline::Scores::sharpness},
                               {"psnr_full", &pipeline::Scores::psnr_full},
                               {"psnr_edge", &pipeline::Scores::psnr_edge},
                               {"psnr_color_mask", &pipeline::Scores::psnr_color},
                               {"ghosting", &pipeline::Scores::ghosting},
                               {"flicker", &pipeline::Scores::flicker},
                               {"predicted_blurred", &pipeline::Scores::predicted_blurred},
                               {"predicted_ghost", &pipeline::Scores::predicted_ghost},
                               {"measured_blurred", &pipeline::Scores::measured_blurred},
                               {"measured_ghost", &pipeline::Scores::measured_ghost}};

json to_json(const pipeline::Scores& s) {
  json j;
  for (const Column& c : kColumns) j[c.name] = s.*c.score;
  return j;
}

pipeline::Scores mean(const std::vector<ScoredView>& rows, const std::string& method) {
  pipeline::Scores m;
  for (const Column& c : kColumns) {
    double sum = 0, known = 0;
    for (const ScoredView& r : rows) {
      const double score = r.scores.at(method).*c.score;
      if (std::isnan(score)) continue;  // this camera has no such score
      sum += score;
      ++known;
    }
    m.*c.score = known > 0 ? sum / known : pipeline::Scores::kUnknown;
  }
  return m;
}

std::string to_csv(const std::vector<ScoredView>& rows, const std::vector<std::string>& methods) {
  std::string csv = "frame,camera,method";
  for (const Column& c : kColumns) csv += text(",", c.name);
  csv += "\n";
  for (const ScoredView& r : rows) {
    for (const std::string& m : methods) {
      csv += text(r.frame, ",", r.serial, ",", m);
      for (const Column& c : kColumns) csv += text(",", r.scores.at(m).*c.score);
      csv += "\n";
    }
  }
  return csv;
}

/// The rows of each frame, in order.
std::map<int, std::vector<ScoredView>> by_frame(const std::vector<ScoredView>& rows) {
  std::map<int, std::vector<ScoredView>> frames;
  for (const ScoredView& row : rows) frames[row.frame].push_back(row);
  return frames;
}

/// How a score of one method goes over the frames: a step is between two that follow each other in the list.
struct Course {
  double lowest = 0, spread = 0, largest_step = 0;
  int lowest_frame = 0;
};

Course course(const std::map<int, std::vector<ScoredView>>& frames, const std::string& method,
              double pipeline::Scores::*score) {
  Course out;
  double sum = 0, squares = 0, last = 0, known = 0;
  bool first = true;
  for (const auto& [frame, rows] : frames) {
    const double now = mean(rows, method).*score;
    if (std::isnan(now)) continue;
    ++known;
    sum += now;
    squares += now * now;
    if (first || now < out.lowest) out.lowest = now, out.lowest_frame = frame;
    if (!first) out.largest_step = std::max(out.largest_step, std::abs(now - last));
    last = now;
    first = false;
  }
  if (known == 0)
    return {.lowest = pipeline::Scores::kUnknown,
            .spread = pipeline::Scores::kUnknown,
            .largest_step = pipeline::Scores::kUnknown};
  const double count = known, average = sum / count;
  out.spread = std::sqrt(std::max(0.0, squares / count - average * average));
  return out;
}

// The columns that some method has a score in: of classes nobody may have asked for.
std::vector<Column> shown_columns(const std::vector<ScoredView>& rows,
                                  const std::vector<std::string>& methods) {
  std::vector<Column> columns;
  for (const Column& c : kColumns)
    if (std::any_of(methods.begin(), methods.end(),
                    [&](const std::string& m) { return !std::isnan(mean(rows, m).*c.score); }))
      columns.push_back(c);
  return columns;
}

void print_table(const std::vector<ScoredView>& rows, const std::vector<std::string>& methods) {
  const std::vector<Column> columns = shown_columns(rows, methods);
  std::printf("%-10s", "mean of");
  for (const Column& c : columns) std::printf(" %17s", c.name);
  std::printf("\n");
  for (const std::string& m : methods) {
    const pipeline::Scores s = mean(rows, m);
    std::printf("%-10s", m.c_str());
    for (const Column& c : columns) std::printf(" %17.4f", s.*c.score);
    std::printf("\n");
  }
  const std::map<int, std::vector<ScoredView>> frames = by_frame(rows);
  if (frames.size() < 2) return;
  for (const std::string& m : methods) {
    const Course c = course(frames, m, &pipeline::Scores::psnr);
    std::printf("%-10s over %zu frames: psnr_mask lowest %.2f (frame %d), spread %.2f, largest step %.2f\n",
                m.c_str(), frames.size(), c.lowest, c.lowest_frame, c.spread, c.largest_step);
  }
}

json over_time(const std::vector<ScoredView>& rows, const std::vector<std::string>& methods) {
  const std::map<int, std::vector<ScoredView>> frames = by_frame(rows);
  json j;
  for (const std::string& m : methods) {
    for (const Column& c : kColumns) {
      const Course at = course(frames, m, c.score);
      j["over_time"][m][c.name] = {{"lowest", at.lowest},
                                   {"lowest_frame", at.lowest_frame},
                                   {"spread", at.spread},
                                   {"largest_step", at.largest_step}};
    }
    for (const auto& [frame, of_frame] : frames)
      j["frames"][std::to_string(frame)][m] = to_json(mean(of_frame, m));
  }
  return j;
}

Result<void> save_reports(const std::filesystem::path& take, const std::vector<ScoredView>& rows,
                          const std::vector<std::string>& methods, const ScoreFiles& files) {
  if (!files.json.empty()) {
    json j = {{"take", take.string()}, {"views", json::array()}};
    for (const std::string& m : methods) j["mean"][m] = to_json(mean(rows, m));
    j.update(over_time(rows, methods));
    for (const ScoredView& r : rows) {
      json scores;
      for (const std::string& m : methods) scores[m] = to_json(r.scores.at(m));
      j["views"].push_back(
          {{"camera", r.serial}, {"frame", r.frame}, {"matte", r.has_matte}, {"scores", scores}});
    }
    if (Result<void> ok = pipeline::save_json(j, files.json); !ok) return ok;
  }
  return files.csv.empty() ? Result<void>() : write_file(files.csv, to_csv(rows, methods));
}

}  // namespace

Result<void> report_scores(const std::filesystem::path& take, const std::vector<ScoredView>& views,
                           const std::vector<std::string>& methods, const ScoreFiles& files) {
  print_table(views, methods);
  return save_reports(take, views, methods, files);
}

json json_of(const std::vector<ScoredView>& views) {
  json all = json::array();
  for (const ScoredView& row : views) {
    json scores = json::object();
    for (const auto& [method, of] : row.scores) scores[method] = to_json(of);
    all.push_back(
        {{"camera", row.serial}, {"frame", row.frame}, {"matte", row.has_matte}, {"scores", scores}});
  }
  return all;
}

Result<std::vector<ScoredView>> views_of(const json& all) {
  std::vector<ScoredView> views;
  try {
    for (const json& j : all) {
      ScoredView view{j.at("camera"), j.at("frame"), j.at("matte"), {}};
      for (const auto& [method, scores] : j.at("scores").items())
        for (const Column& c : kColumns)
          view.scores[method].*c.score =
              scores.at(c.name).is_null() ? pipeline::Scores::kUnknown : scores.at(c.name).get<double>();
      views.push_back(std::move(view));
    }
  } catch (const json::exception& e) {
    return fail(ErrorCode::BadData, text("holds no scores (", e.what(), ")"));
  }
  return views;
}

}  // namespace floatstage::apps
