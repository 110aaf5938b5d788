#include "pipeline/calibrate/clip.h"

#include <algorithm>
#include <cmath>

#include "calib/picture_motion.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kMost = 20;  // that stay of a clip: every pair of them is compared
constexpr std::size_t kAsked = 5;  // neighbours that are compared
constexpr double kNext = 0.005;    // share of the longer side: neighbours of a clip shift by less
constexpr double kTurned = 0.5;    // share of what two pictures show that a turn explains: no parallax
constexpr int kTelling = 50;       // matches

Result<calib::PictureMotion> motion(const std::filesystem::path& from, const std::filesystem::path& to,
                                    double contrast) {
  const Result<Image> a = load_still(from);
  if (!a) return forward(a);
  const Result<Image> b = load_still(to);
  if (!b) return forward(b);
  if (a->width != b->width || a->height != b->height) return calib::PictureMotion{};
  return calib::picture_motion(*a, *b, contrast);
}

double percent(double share) { return std::round(1e4 * share) / 100; }

}  // namespace

Result<void> check_one_scene(const std::vector<std::pair<std::string, std::filesystem::path>>& pictures,
                             double contrast) {
  constexpr std::size_t kAll = 6;  // pictures: so few are compared each with each
  constexpr double kCommon = 20;   // matches
  constexpr double kSame = 0.002;  // shift, of the longer side
  const std::size_t n = pictures.size();
  std::vector<double> most(std::min(n, kAll), 0);  // matches of a picture with another
  for (std::size_t i = 0; i < most.size(); ++i)
    for (std::size_t k = i + 1; n <= kAll ? k < n : k == i + 1; ++k) {
      const std::size_t from = n <= kAll ? i : i * (n - 1) / kAll, to = n <= kAll ? k : from + 1;
      const Result<calib::PictureMotion> m = motion(pictures[from].second, pictures[to].second, contrast);
      if (!m) return forward(m);
      // Of so few, two from one place are one picture twice: a photograph and its matte.
      const double matches = n <= kAll && m->shift < kSame ? 0 : m->matches;
      most[i] = std::max(most[i], matches);
      if (n <= kAll) most[k] = std::max(most[k], matches);
    }
  if (median(std::move(most)) >= kCommon) return {};
  return fail(
      ErrorCode::BadData,
      text("no board, no calibration, and the pictures show no common scene from several places: of '",
           pictures[0].first, "', '", pictures[1].first, "' and ", n - 2,
           " more hardly one has anything that is found again, elsewhere, in a neighbour; name one scene's "
           "folder, with cameras 15° and less apart, or show a board (--target)"));
}

Result<std::optional<std::string>> thin_out_clip(
    std::vector<std::pair<std::string, std::filesystem::path>>& pictures, double contrast) {
  const std::size_t n = pictures.size();
  if (n < 2) return std::optional<std::string>();
  std::vector<double> shifts;
  for (std::size_t i = 0; i < kAsked; ++i) {
    const std::size_t at = i * (n - 1) / kAsked;
    const Result<calib::PictureMotion> next = motion(pictures[at].second, pictures[at + 1].second, contrast);
    if (!next) return forward(next);
    shifts.push_back(next->matches >= kTelling ? next->shift : 1);
  }
  const double shift = median(std::move(shifts));
  if (shift > kNext) return std::optional<std::string>();
  const std::filesystem::path folder = pictures.front().second.parent_path();
  const std::string clip =
      text(n, " pictures in ", folder.string(), " are one clip: from one to the next they shift by ",
           percent(shift), " % of their longer side");
  double least = 1;
  for (const auto& [a, b] :
       {std::pair(std::size_t{0}, n / 2), std::pair(n / 2, n - 1), std::pair(std::size_t{0}, n - 1)}) {
    const Result<calib::PictureMotion> far = motion(pictures[a].second, pictures[b].second, contrast);
    if (!far) return forward(far);
    least = std::min(least, far->matches >= kTelling ? far->turned : 0.0);
  }
  if (least >= kTurned)
    return fail(
        ErrorCode::BadData,
        text(clip, ", and its camera hardly left its place: ", percent(least),
             " % of what its first, middle and last picture share lies where a turn of the camera puts "
             "it, and the rest may have moved by itself. That tells neither where cameras are nor a lens. Of "
             "a "
             "rig, name the folder that has a picture or a video of every camera; for this camera's lens, "
             "show it "
             "a board; for a scene, carry the camera around it"));
  std::vector<std::pair<std::string, std::filesystem::path>> some;
  const std::size_t step = (n + kMost - 1) / kMost;
  for (std::size_t i = 0; i < n; i += step) some.push_back(std::move(pictures[i]));
  pictures = std::move(some);
  return std::optional(text(clip, "; ", pictures.size(), " of them are used, spread evenly"));
}

}  // namespace floatstage::pipeline
