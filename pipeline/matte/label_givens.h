#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"
#include "pipeline/label_record.h"

namespace floatstage::pipeline {

/// What somebody said about labels, painted: of each pixel of a photograph, which labels may be there, bit i
/// for the label i of the list; 0: nothing was said of it.
using LabelsAllowed = std::vector<std::uint32_t>;

/// By frame, and in it by camera of the rig.
using LabelGivens = std::map<int, std::map<int, LabelsAllowed>>;

/// Somebody's masks of a label: <serial>/<frame>.png in `folder`, of any cameras and frames.
struct LabelMasks {
  std::string label;
  std::filesystem::path folder;
};

/// Reads masks as they are given: a label is where its mask is above 127 (alpha where there is one, else
/// brightness), and nowhere else in that photograph; of several masks over one pixel the last label's counts.
/// Each is handed to `each`, one channel. NotFound for a folder that is not there or holds no mask;
/// InvalidArgument for a camera or frame that the take does not have; BadData for sizes, and for a mask under
/// which the sum has nothing.
Result<void> read_label_masks(
    const capture::TakeReader& take, const LabelMasks& masks,
    const std::function<Result<void>(int camera, int frame, const Image& mask)>& each);

/// Everything that was said: masks that lie in `masks` (mattes/labels of the take, or what is to become
/// that), a folder a label; label mattes of unknown origin, which are masks too, and clicks, which are discs
/// of a two-hundredth of the picture's longer side. `hashes` gets those of the files. Errors: those above;
/// InvalidArgument for a click outside its picture or outside the sum, and for a label of which nothing is
/// said.
Result<LabelGivens> label_givens(const capture::TakeReader& take, const LabelRecord& record,
                                 const std::filesystem::path& masks, std::vector<std::string>& hashes);

/// Whether label mattes of unknown origin lie there: nobody overwrites them.
Result<bool> is_others_label_matte(const TakeLayout& layout, const LabelRecord& record,
                                   const std::string& label, const std::string& serial, int frame);

}  // namespace floatstage::pipeline
