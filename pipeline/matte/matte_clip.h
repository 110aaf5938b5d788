#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Who is to be cut out, as masks of some frames.
struct ClipGuide {
  std::string label;  ///< a folder's name; not "all", "doubts" or "labels.json"
  std::filesystem::path
      masks;  ///< a PNG: of the frame of its name, else of the first; a folder of PNGs, each
              ///< of the frame of its name or number. Alpha where there is, else brightness
};

/// A click on somebody, a disc of a two-hundredth of the picture's longer side.
struct ClipClick {
  std::string label;
  int frame = 0;
  double x = 0, y = 0;  ///< px of the clip's pictures
};

struct MatteClipOptions {
  std::filesystem::path media;  ///< a video, or a folder of pictures
  std::vector<ClipGuide> guides;
  /// Empty, or strokes about the labels as mattes/edits.json of a take has them, of one camera, whatever it
  /// is called. Garbage masks are nobody's in their frames.
  std::filesystem::path edits = {};
  std::vector<ClipClick> clicks = {};  ///< heard before the strokes of their frame
  std::filesystem::path out;           ///< a new folder: <label>/<frame>.png, all/<frame>.png, labels.json
  Progress* progress = nullptr;
};

struct ClipLabel {
  std::string name;
  int keyframes = 0;      ///< frames that somebody gave masks of
  int strokes = 0;        ///< strokes and clicks that name it
  double subject = 0;     ///< mean share of the picture
  double jump = 0;        ///< largest change of area from a frame to the next, as a share of the larger
  int jumps_at = -1;      ///< the second frame of those two
  int first_absent = -1;  ///< first frame in which nothing of it is left; -1: it is always there
  double border = 0;      ///< largest share of the picture's border that is covered
  /// The most that was lost on the way from a key frame to an end of the clip and back (LabelReturn), and
  /// that way; absent where both ends have key frames.
  struct Lost {
    int key = 0, end = 0;
    double share = 0;
    double jump = 0;   ///< the most of it that was not found again from a frame to the next on that way …
    int jumps_at = 0;  ///< … and the later of the two
  };
  std::optional<Lost> lost = {};
};

struct MatteClipReport {
  int frames = 0, width = 0, height = 0;
  std::vector<ClipLabel> labels;
  std::vector<std::string> doubts;  ///< a sentence each, with the frame, for mattes that cannot be trusted
  std::vector<std::string> idle;    ///< likewise for strokes that changed nothing
  double seconds = 0;
};

/// Mattes of a clip from masks of a few of its frames, and from strokes and clicks, which correct what is
/// made of masks, or begin a label of which there are none; no take and no rig are needed (matting/labels).
/// Every frame has a matte for each label, frames without masks too; `all` is their sum. Labels: those of
/// `guides` in their order, then those that clicks or strokes alone name, in that of the alphabet. Whole or
/// not at all. doubts/<label>.png shows the worst frame of a label in doubt. Errors: AlreadyExists for `out`;
/// NotFound for media, masks or edits; InvalidArgument for labels, masks, strokes and clicks that fit no
/// frame or lie outside of the picture; those of load_matte_edits() and follow_labels(); Cancelled; Io.
Result<MatteClipReport> matte_clip(const MatteClipOptions& options);

}  // namespace floatstage::pipeline
