#include "calib/colmap_model.h"

#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "calib/formats/text_lines.h"
#include "core/text.h"

namespace floatstage {

Result<ColmapPoints> parse_colmap_points(std::string_view bytes, std::string_view name) {
  ColmapPoints result;
  std::map<int, int> images;
  long long seen = 0;
  double error_sum = 0;
  int line_number = 0;
  while (!bytes.empty()) {
    ++line_number;
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    const std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    std::vector<std::string_view> words;
    for (std::size_t at = line.find_first_not_of(" \t\r"); at != line.npos; at = line.find_first_not_of(" \t\r", at)) {
      const std::size_t stop = std::min(line.find_first_of(" \t\r", at), line.size());
      words.push_back(line.substr(at, stop - at));
      at = stop;
    }
    if (words.empty() || words[0].starts_with('#')) continue;
    auto bad = [&](const char* what) { return fail(ErrorCode::BadData, text(name, ": line ", line_number, ": ", what)); };
    // POINT3D_ID X Y Z R G B ERROR, then pairs IMAGE_ID POINT2D_IDX.
    if (words.size() < 12 || words.size() % 2 != 0) return bad("a point needs its place, colour, error and at least two observations");
    const std::optional<double> error = parse_number(words[7]);
    if (!error || !std::isfinite(*error) || *error < 0) return bad("the error is no number");
    ColmapPoint point;
    for (int i = 0; i < 3; ++i) {
      const std::optional<double> v = parse_number(words[static_cast<std::size_t>(1 + i)]);
      if (!v || !std::isfinite(*v)) return bad("the place is no number");
      point.position[i] = *v;
    }
    std::set<int> here;
    for (std::size_t i = 8; i < words.size(); i += 2) {
      const std::optional<long> image = parse_integer(words[i]), index = parse_integer(words[i + 1]);
      if (!image || *image < 0 || *image > 1'000'000'000) return bad("an image id is no number");
      if (!index || *index < 0 || *index > 1'000'000'000) return bad("a keypoint's index is no number");
      if (here.insert(static_cast<int>(*image)).second) point.track.emplace_back(static_cast<int>(*image), static_cast<int>(*index));
    }
    result.points.push_back(std::move(point));
    error_sum += *error;
    seen += static_cast<long long>(here.size());
    for (const int image : here) ++images[image];
  }
  if (result.points.empty()) return fail(ErrorCode::BadData, text(name, ": there are no points"));
  result.mean_track = static_cast<double>(seen) / static_cast<double>(result.points.size());
  result.mean_error = error_sum / static_cast<double>(result.points.size());
  result.of_image.assign(images.begin(), images.end());
  return result;
}

Result<std::vector<ColmapImage>> parse_colmap_keypoints(std::string_view bytes, std::string_view name) {
  TextLines lines(bytes, name);
  std::vector<ColmapImage> images;
  while (const std::optional<TextLine> line = lines.next_filled('#')) {
    // IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of X Y POINT3D_ID.
    const std::optional<long> id = line->words.size() >= 10 ? parse_integer(line->words[0]) : std::nullopt;
    if (!id || *id < 0 || *id > 1'000'000'000) return lines.bad("an image begins with its id and ends with its name");
    ColmapImage image{.id = static_cast<int>(*id), .name = std::string(line->words[9]), .keypoints = {}};
    if (const std::optional<TextLine> points = lines.next()) {
      if (points->words.size() % 3 != 0) return lines.bad("keypoints are triples X Y POINT3D_ID");
      for (std::size_t i = 0; i < points->words.size(); i += 3) {
        const std::optional<double> x = parse_number(points->words[i]), y = parse_number(points->words[i + 1]);
        if (!x || !y) return lines.bad("a keypoint's place is no number");
        image.keypoints.emplace_back(*x, *y);
      }
    }
    images.push_back(std::move(image));
  }
  return images;
}

}  // namespace floatstage
