#pragma once

#include <functional>
#include <map>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/labels/label_strokes.h"

// Labels that somebody gave in some frames of a clip, followed through all of them: camera and subjects may
// move.
namespace floatstage::matting {

/// A clip whose pictures can be had in any order: RGB, of one size, at least 32 px a side.
struct LabelClip {
  int frames = 0;
  std::function<Result<Image>(int frame)> picture;
};

/// What somebody said of one frame: masks of some labels, 1 to 254, each one channel of the picture's size,
/// the label where it is above 127. Outside its mask a label is not; where masks overlap the highest label
/// has the pixel. Of labels that it does not name the frame says nothing.
using LabelMasks = std::map<int, Image>;

struct LabelClipOptions {
  double band = 0.03;  ///< of the picture's smaller side: how far from a carried edge labels are asked again
  double slack = 3;    ///< px by which a carried edge is off, as a rule
  double uncovered = 2;  ///< what a label costs, beside the background, where nothing is known from before
  double color = 1;      ///< how much colours count
  double smooth = 4;     ///< how much edges cost

  Result<void> check() const;
};

/// A frame is finished: its picture, and of each pixel the label, 0 where there is none. Frames come each
/// once, in an order of their own. An error ends the work and is passed on.
using LabelDone = std::function<Result<void>(int frame, const Image& picture, const Image& labels)>;

/// How labels hold where one key frame speaks alone, towards an end of the clip: they are followed there and
/// back, and what then differs in the key frame was lost on the way, about half of it on the way there
/// (Kalal, Mikolajczyk, Matas, "Forward-backward error", 2010).
struct LabelReturn {
  int key = 0, end = 0;      ///< frames; end may lie before key
  std::vector<double> lost;  ///< by label, 0 is the background's: 1 - IoU in the key frame; of labels that
                             ///< are not in it 0
  /// By label: the most of it that flow did not find again from a frame to the next on the way there, and the
  /// later of the two: where the clip jumps, nearly all.
  struct Jump {
    double share = 0;
    int frame = 0;
  };
  std::vector<Jump> jumps;
};

/// The labels 1 … `labels` of all frames from those of the key frames. They are carried along dense flow
/// from the nearest key frames before and after, and each frame is the cut of one energy
/// (docs/matting.md): colours of every label in local windows, distance to the carried
/// edges, contrast. A key frame has its masks as they are. Memory: one byte a pixel and frame between two key
/// frames. Each way towards an end of the clip is gone
/// back, too: what comes back is returned, one for each end that has no key frame. Deterministic; one thread.
/// Errors: InvalidArgument for options, a clip without key frames, frames or labels that are not there, sizes
/// that differ; those of the callbacks.
Result<std::vector<LabelReturn>> follow_labels(const LabelClip& clip, const std::map<int, LabelMasks>& keys,
                                               int labels, const LabelDone& done,
                                               const LabelClipOptions& options = {});

/// What somebody marked in frames of a clip, in the order in which it holds.
using LabelStrokes = std::map<int, std::vector<LabelStroke>>;

struct LabelsFollowed {
  std::vector<LabelReturn> returns;
  /// By frame with strokes, what became of them: effects and pixels that turned; without the labels.
  std::map<int, StrokedLabels> heard;
};

/// The same with strokes, of frames with masks or without. They correct what the labels of their frame are
/// without them (stroke_labels()). A frame whose labels they change is a key frame from then on, of all
/// labels, from which the frames to either side are followed anew, up to the next key frames; strokes that
/// change nothing change no frame. What frames on the way were given holds again afterwards. Without any mask
/// labels begin with what turns in the first frame that has strokes. Each stroke that changes a frame costs
/// the frames between its key frames once more.
Result<LabelsFollowed> follow_labels(const LabelClip& clip, const std::map<int, LabelMasks>& keys,
                                     const LabelStrokes& strokes, int labels, const LabelDone& done,
                                     const LabelClipOptions& options = {});

/// A matte for each label from the labels of a picture: the edges by closed form, what overlaps shared so
/// that all together are never more than opaque. Errors: those of refine_matte().
Result<std::vector<Image>> label_mattes(const Image& picture, const Image& labels, int count);

}  // namespace floatstage::matting
