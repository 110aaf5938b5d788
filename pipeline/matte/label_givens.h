#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/label_record.h"

namespace floatstage::pipeline {

/// What somebody said about labels, painted: of each pixel of a photograph, which labels may be there, bit i
/// for the label i of the list; 0: nothing was said of it.
using LabelsAllowed = std::vector<std::uint32_t>;

/// By frame, and in it by camera of the rig.
using LabelGivens = std::map<int, std::map<int, LabelsAllowed>>;

/// What was said of a frame, by camera; null: nothing.
const std::map<int, LabelsAllowed>* said_of(const LabelGivens& givens, int frame);

/// Somebody's masks of a label: <serial>/<frame>.png in `folder`, of any cameras and frames.
struct LabelMasks {
  std::string label;
  std::filesystem::path folder;
};

/// A word on who is who: what lies within the stroke's radius of its line is its subject.
struct LabelWord {
  std::string serial;
  int frame = 0;
  MatteStroke stroke;
};

/// All words: the clicks of the record, discs of a two-hundredth of the picture's longer side, then the
/// strokes of `edits` that have a subject, by camera and frame. Of two over one pixel the later one counts.
std::vector<LabelWord> label_words(const Rig& rig, const LabelRecord& record, const MatteEdits& edits);

/// Reads masks as they are given: a label is where its mask is above 127 (alpha where there is one, else
/// brightness), and nowhere else in that photograph; of several masks over one pixel the last label's counts.
/// Each is handed to `each`, one channel. NotFound for a folder that is not there or holds no mask;
/// InvalidArgument for a camera or frame that the take does not have; BadData for sizes, and for a mask under
/// which the sum has nothing.
Result<void> read_label_masks(
    const capture::TakeReader& take, const LabelMasks& masks,
    const std::function<Result<void>(int camera, int frame, const Image& mask)>& each);

/// Everything that was said: masks that lie in `masks` (mattes/labels of the take, or what is to become
/// that), a folder a label; label mattes of unknown origin, which are masks too; and, over those, `words`.
/// `hashes` gets those of the files. Errors: those above; InvalidArgument for a word outside its picture or
/// outside the sum, and for a label of which nothing is said; NotFound for a word where there is no sum.
Result<LabelGivens> label_givens(const capture::TakeReader& take, const LabelRecord& record,
                                 const std::vector<LabelWord>& words, const std::filesystem::path& masks,
                                 std::vector<std::string>& hashes);

/// Whether label mattes of unknown origin lie there: nobody overwrites them.
Result<bool> is_others_label_matte(const TakeLayout& layout, const LabelRecord& record,
                                   const std::string& label, const std::string& serial, int frame);

}  // namespace floatstage::pipeline
