#include <cmath>

#include "calib/exif_lens.h"
#include "calib/markerless.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/calibrate/clip.h"
#include "pipeline/calibrate/session_draft.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// The picture of a calibrated camera among all that lie there.
std::optional<fs::path> picture_of(const std::string& serial, const std::string& image,
                                   const FolderSurvey& survey) {
  for (const MediaSet& set : survey.sets)
    for (const SurveyedMedia& m : set.media) {
      if (m.name == serial && !m.stills.empty() && set.kind != MediaSet::Kind::Pictures)
        return m.stills.front();
      for (const fs::path& p : m.stills)
        if (p.filename() == fs::path(image).filename() || p.stem() == serial || p.filename() == serial)
          return p;
    }
  return std::nullopt;
}

using Pictures = std::vector<std::pair<std::string, fs::path>>;

// Bare surfaces are looked at more closely than the program would by itself.
Result<double> contrast_of(const SessionDraft& d, const Pictures& pictures) {
  constexpr std::size_t kSample = 8;
  std::vector<Image> some;
  const std::size_t n = std::min(kSample, pictures.size());
  for (std::size_t i = 0; i < n; ++i) {
    Result<Image> picture = load_still(pictures[i * pictures.size() / n].second);
    if (!picture) return forward(picture);
    some.push_back(*std::move(picture));
  }
  return calib::contrast_for(some, d.options.threads);
}

void write_contrast(SessionDraft& d, double contrast) {
  if (contrast == calib::kUsualContrast) return;
  d.tables += text("contrast = ", contrast, "\n");
  d.found(
      text("the pictures show little texture, so fainter points are looked for, too (contrast = ", contrast,
           ", ", calib::kUsualContrast, " elsewhere); the sigmas in the report say what that is worth"));
}

}  // namespace

Result<bool> draft_known_scene(SessionDraft& d) {
  if (!d.survey.calibration) return false;
  const Rig& rig = d.survey.rig.rig;
  Pictures pictures;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (const auto p = picture_of(rig.cameras[i].serial, d.survey.rig.image_names[i], d.survey))
      pictures.emplace_back(rig.cameras[i].serial, *p);
  if (pictures.size() < 2) return false;
  d.found(text("no board in any picture that was looked at, and a picture of ", pictures.size(),
               " of the calibrated cameras"));
  d.assume(
      "the calibration is nearly right: its lenses are kept, its poses are where the solver starts, and the "
      "report says which camera has moved");
  const Result<double> contrast = contrast_of(d, pictures);
  if (!contrast) return forward(contrast);
  d.tables += "\n[markerless]\n";
  write_contrast(d, *contrast);
  d.known("fixed", "start");
  for (const auto& [serial, file] : pictures) d.camera(serial, "scene", d.path(file));
  return true;
}

Result<void> draft_unknown_scene(SessionDraft& d) {
  Pictures pictures;
  const MediaSet* chosen = nullptr;
  std::size_t most = 0;
  for (const MediaSet& set : d.survey.sets) {
    if (set.kind == MediaSet::Kind::Videos) continue;
    const std::size_t n =
        set.kind == MediaSet::Kind::Pictures ? set.media.front().stills.size() : set.media.size();
    if (n > most) most = n, chosen = &set;
  }
  if (!chosen || most < 3)
    return fail(
        ErrorCode::NotFound,
        "no picture that was looked at shows a board, there is no calibration of another program, and there "
        "are not three pictures of a scene; show a board to the cameras, or say which it is with --target");
  if (chosen->kind == MediaSet::Kind::Pictures)
    for (const fs::path& p : chosen->media.front().stills)
      pictures.emplace_back(usable_serial(p.stem().string()), p);
  else
    for (const SurveyedMedia& m : chosen->media)
      pictures.emplace_back(usable_serial(m.name), m.stills.front());
  const bool one_folder = chosen->kind == MediaSet::Kind::Pictures;
  const Result<double> contrast = contrast_of(d, pictures);
  if (!contrast) return forward(contrast);
  if (Result<void> ok = check_one_scene(pictures, *contrast); !ok) return ok;
  if (one_folder) {
    const Result<std::optional<std::string>> clip = thin_out_clip(pictures, *contrast);
    if (!clip) return forward(clip);
    if (*clip) d.found(**clip);
  }
  std::string camera;
  if (const Result<std::string> bytes = read_file(pictures.front().second))
    if (const calib::ExifLens lens = calib::exif_lens(*bytes); lens.focal_per_width) {
      d.found(text("EXIF: ", lens.camera.empty() ? "a camera" : lens.camera, ", focal length ",
                   std::round(100 * *lens.focal_per_width) / 100, " of the picture's longer side"));
      camera = lens.camera;
    }
  d.found(text("no board and no calibration; ", pictures.size(), " pictures of a scene in ",
               chosen->folder.string()));
  double metres = d.options.distance.value_or(0);
  if (!(metres > 0) && d.options.ask)
    metres = d.options
                 .ask(text("How far apart are cameras '", pictures[0].first, "' and '", pictures[1].first,
                           "', in millimetres?"))
                 .value_or(0);
  if (!(metres > 0)) {
    metres = 1;
    d.assume(
        text("cameras '", pictures[0].first, "' and '", pictures[1].first,
             "' are 1 m apart: pictures do not show how large a scene is. Measure a distance between two "
             "cameras and correct 'between' and 'distance', or give --distance"));
  }
  d.assume(one_folder
               ? "all pictures are of one camera that was carried about, or of cameras alike, with one lens: "
                 "they lie in one folder (lens = \"separate\" says otherwise)"
               : "every camera has a lens of its own: they have folders of their own (lens = \"shared\" says "
                 "otherwise)");
  d.tables +=
      text("\n[markerless]\nlens = \"", one_folder ? "shared" : "separate", "\"\nbetween = [",
           d.quoted(pictures[0].first), ", ", d.quoted(pictures[1].first), "]\ndistance = ", metres, "\n");
  write_contrast(d, *contrast);
  for (const auto& [serial, file] : pictures) d.camera(serial, "scene", d.path(file));
  return {};
}

}  // namespace floatstage::pipeline
