#include "pipeline/calibrate/board_search.h"

#include <algorithm>

#include <toml++/toml.h>

#include "calib/board_identification.h"
#include "calib/detect.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kMostPictures = 24;  // of a set of stills
constexpr std::size_t kOfVideo = 10;       // of a video: a board comes into view some time
constexpr int kVideoStep = 12;             // pictures of a video from one sample to the next

// Some pictures of a camera, spread over what it has.
Result<void> sample(const SurveyedMedia& media, std::size_t count, std::vector<Image>& out) {
  if (media.video.empty()) {
    const std::size_t n = std::min(count, media.stills.size());
    for (std::size_t i = 0; i < n; ++i) {
      const std::filesystem::path& file = media.stills[i * media.stills.size() / n];
      Result<Image> picture = load_still(file);
      if (!picture) return forward(picture);
      out.push_back(*std::move(picture));
    }
    return {};
  }
  Result<PictureStream> stream = PictureStream::open({media.video, {}}, {0, std::nullopt, kVideoStep});
  if (!stream) return forward(stream);
  for (std::size_t i = 0; i < kOfVideo; ++i) {
    Result<std::optional<Image>> picture = stream->next();
    if (!picture) return forward(picture);
    if (!*picture) break;
    out.push_back(**std::move(picture));
  }
  return {};
}

Result<std::vector<Image>> sample_set(const MediaSet& set) {
  std::vector<Image> out;
  const std::size_t each = std::max<std::size_t>(1, kMostPictures / set.media.size());
  for (const SurveyedMedia& m : set.media) {
    if (out.size() >= kMostPictures && m.video.empty()) break;
    if (Result<void> ok = sample(m, each, out); !ok) return forward(ok);
  }
  return out;
}

int pictures_with(const calib::TargetDesign& design, const std::vector<Image>& pictures, int threads) {
  std::vector<calib::PictureToDetect> list;
  for (const Image& p : pictures) list.push_back({"", "", [&p] { return Result<Image>(p); }});
  const std::vector<calib::Detection> found =
      calib::detect_all(design, list, {.detect = {.diagnose = false}, .threads = threads});
  return static_cast<int>(
      std::count_if(found.begin(), found.end(), [](const calib::Detection& d) { return !d.points.empty(); }));
}

}  // namespace

Result<calib::TargetDesign> read_board_file(const std::filesystem::path& file) {
  if (file.extension() != ".toml") return calib::load_target(file);
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  toml::table t;
  try {
    t = toml::parse(*bytes);
  } catch (const toml::parse_error& e) {
    return fail(ErrorCode::BadData,
                text(file.string(), ": line ", e.source().begin.line, ": not TOML: ", e.description()));
  }
  calib::CharucoBoard b;
  b.columns = t["columns"].value_or(0);
  b.rows = t["rows"].value_or(0);
  b.square = t["square_size_override_cm"].value_or(0.0) / 100;
  b.marker = b.square * t["aruco_scale"].value_or(0.0);
  b.dictionary = t["dictionary"].value_or(std::string());
  b.inverted = t["inverted"].value_or(false);
  // By its words, as a person would write it: the dictionary's name in our spelling, lengths in round
  // figures.
  Result<calib::TargetDesign> read = calib::parse_target(
      text("charuco columns=", b.columns, " rows=", b.rows, " square=", 1e3 * b.square,
           "mm marker=", 1e3 * b.marker, "mm dictionary=", b.dictionary, b.inverted ? " inverted" : ""));
  if (!read)
    return fail(read.error().code, text(file.string(), ": describes no board: ", read.error().message));
  return read;
}

Result<std::optional<FoundBoard>> find_board(const FolderSurvey& survey,
                                             const std::optional<calib::TargetDesign>& given, int threads,
                                             Progress* watch) {
  std::optional<calib::TargetDesign> described = given;
  std::string how = "as it was given";
  if (!described && !survey.board.empty())
    if (const Result<calib::TargetDesign> read = read_board_file(survey.board)) {
      described = *read;
      how = text("from ", survey.board.string());
    }
  std::optional<FoundBoard> best;
  ProgressPart progress(watch, "folders", survey.sets.size());
  for (std::size_t s = 0; s < survey.sets.size(); ++s) {
    if (is_cancelled(watch)) return cancelled_unwritten();
    Result<std::vector<Image>> pictures = sample_set(survey.sets[s]);
    if (!pictures) return forward(pictures);
    const auto looked_at = static_cast<int>(pictures->size());
    std::optional<FoundBoard> here;
    if (described) {
      if (const int n = pictures_with(*described, *pictures, threads); n > 0)
        here = FoundBoard{s, *described, true, n, looked_at, how};
    } else if (const auto board = calib::identify_board(*pictures, 1)) {
      here = FoundBoard{s, board->design, false, board->pictures, looked_at, "by its look: " + board->how};
    }
    if (here && (!best || here->pictures > best->pictures)) best = std::move(here);
    progress.advance();
  }
  return best;
}

}  // namespace floatstage::pipeline
