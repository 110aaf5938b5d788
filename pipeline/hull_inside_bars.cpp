#include "pipeline/hull_inside_bars.h"

#include <algorithm>
#include <memory>

namespace floatstage::pipeline {
namespace {

// A view of a part of the matte; shares its memory.
Matte part_of(const Matte& matte, const PixelBox& box) {
  if (matte.empty()) return matte;
  Matte part = matte;
  part.width = box.width, part.height = box.height;
  part.alpha = {matte.alpha, matte.alpha.get() + static_cast<std::size_t>(box.y) * matte.stride + box.x};
  return part;
}

Matte whole_of(const Matte& part, const PixelBox& box, const CameraModel& model) {
  if (part.empty()) return part;
  Image whole(model.width, model.height, 1);
  for (int y = 0; y < part.height; ++y) std::copy_n(part.row(y), part.width, whole.at(box.x, box.y + y));
  return make_matte(part.source, whole);
}

}  // namespace

Result<void> hull_inside_bars(const Rig& rig, const std::vector<Matte>& mattes,
                              const capture::AddedFile& added, const recon::HullOptions& options,
                              recon::HullWorkspace& workspace, recon::HullReport& report) {
  Rig inner = rig;
  std::vector<Matte> seen = mattes;
  std::vector<PixelBox> boxes;
  bool any = false;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    CameraModel& m = inner.cameras[c].model;
    const AddedContent content = added.of(rig.cameras[c].serial);
    boxes.push_back(inside(content, m.width, m.height));
    if (!content.bars() || boxes[c].empty()) continue;
    any = true;
    m.cx -= boxes[c].x, m.cy -= boxes[c].y;
    m.width = boxes[c].width, m.height = boxes[c].height;
    seen[c] = part_of(mattes[c], boxes[c]);
  }
  if (!any) return recon::visual_hull(rig, mattes, options, workspace, report);
  if (Result<void> ok = recon::visual_hull(inner, seen, options, workspace, report); !ok) return ok;
  for (recon::SilhouetteVerdict& v : report.verdicts) {
    const auto c = static_cast<std::size_t>(v.camera);
    v.lost_where = whole_of(v.lost_where, boxes[c], rig.cameras[c].model);
    v.gained_where = whole_of(v.gained_where, boxes[c], rig.cameras[c].model);
  }
  return {};
}

}  // namespace floatstage::pipeline
