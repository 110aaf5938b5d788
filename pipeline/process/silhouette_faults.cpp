#include "pipeline/process/silhouette_faults.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "core/file_presence.h"
#include "core/frame_pixels.h"
#include "core/text.h"
#include "recon/hull_cover.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

constexpr const char* kSilhouettes = "silhouettes";  // DoubtPicture::of

double size_of(double lost, double gained) { return std::max(lost, gained); }

// What one frame's clean-up cost.
void add_cost(const json& cleanup, int frame, std::optional<CleanupCost>& all) {
  if (!all) all.emplace();
  ++all->meshes;
  const json triangles = cleanup.value("triangles", json::array());
  if (triangles.size() == 2 && triangles[1].is_number_integer())
    all->most_triangles = std::max(all->most_triangles, triangles[1].get<int>());
  const double loss = cleanup.value("iou_loss", 0.0);
  if (all->meshes > 1 && loss <= all->iou_loss) return;
  all->iou_loss = loss;
  all->frame = frame;
  all->serial = cleanup.value("camera", "");
}

}  // namespace

std::string sentence(const SilhouetteFault& fault) {
  const auto percent = [](double share) { return std::lround(100 * share); };
  std::string what = fault.lost >= fault.gained
                         ? text("lacks ", percent(fault.lost), " % of what the others see")
                         : text("shows ", percent(fault.gained), " % of subject that no other confirms");
  if (fault.frames > 1) what += text(" in frame ", fault.worst, " (", fault.frames, " frames in all)");
  if (fault.frames == 1) what += text(" in frame ", fault.worst);
  if (!fault.picture.empty()) what += text(": ", fault.picture.string());
  return text("camera '", fault.serial, "' ", what);
}

std::string sentence(const CleanupCost& cost) {
  return text("clean-up left up to ", cost.most_triangles,
              " triangles a mesh; silhouettes' IoU fell by up to ", std::ceil(cost.iou_loss * 1e4) / 1e4,
              " (camera '", cost.serial, "', frame ", cost.frame, ")");
}

Image evidence_picture(const Image& rgb, const Matte& matte, const recon::SilhouetteVerdict& verdict) {
  Image out = rgb;
  const auto blend = [](std::uint8_t& value, int towards) {
    value = static_cast<std::uint8_t>((value + towards) / 2);
  };
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      std::uint8_t* pixel = out.at(x, y);
      const bool subject = matte.row(y)[x] >= 128;
      const bool lost = !subject && verdict.lost_where.row(y)[x] != 0,
                 gained = subject && verdict.gained_where.row(y)[x] != 0;
      if (!subject && !lost) {
        for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(pixel[c] / 3);
      } else if (lost || gained) {
        for (int c = 0; c < 3; ++c) blend(pixel[c], c == (lost ? 0 : 2) ? 255 : 0);
      }
    }
  }
  return out;
}

void EvidenceCollector::note(int frame, const recon::HullReport& hull, const std::vector<Matte>& mattes) {
  const std::lock_guard lock(mutex_);
  cameras_.resize(std::max(cameras_.size(), mattes.size()));
  for (const recon::SilhouetteVerdict& verdict : hull.verdicts) {
    std::optional<Worst>& worst = cameras_[static_cast<std::size_t>(verdict.camera)];
    const double size = size_of(verdict.lost, verdict.gained);
    if (worst) {
      const double before = size_of(worst->verdict.lost, worst->verdict.gained);
      if (size < before || (size == before && frame > worst->frame)) continue;
    }
    worst = {frame, verdict, mattes[static_cast<std::size_t>(verdict.camera)]};
  }
}

Result<void> EvidenceCollector::save(capture::TakeReader& take, const std::filesystem::path& folder) const {
  DoubtPictures pictures(folder);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    const std::optional<Worst>& worst = cameras_[c];
    if (!worst) continue;
    const Result<Frame> photograph = take.frame(static_cast<int>(c), worst->frame);
    if (!photograph || photograph->empty()) continue;
    const Result<Image> rgb = to_rgb(*photograph);
    if (!rgb) continue;
    const std::string& serial = take.rig().cameras[c].serial;
    if (Result<void> ok =
            pictures.put(picture_name(serial, worst->frame), picture_of_fault(serial, worst->frame),
                         evidence_picture(*rgb, worst->matte, worst->verdict));
        !ok)
      return ok;
  }
  return {};
}

json silhouettes_json(const Rig& rig, const std::vector<recon::SilhouetteVerdict>& verdicts) {
  json j = json::object();
  for (const recon::SilhouetteVerdict& verdict : verdicts)
    j[rig.cameras[static_cast<std::size_t>(verdict.camera)].serial] = {{"lost", verdict.lost},
                                                                       {"gained", verdict.gained}};
  return j;
}

json cleanup_json(const Rig& rig, const recon::MeshCleanupReport& cleanup) {
  const auto worst = std::max_element(cleanup.iou_loss.begin(), cleanup.iou_loss.end());
  const auto camera = static_cast<std::size_t>(worst - cleanup.iou_loss.begin());
  return {{"triangles", {cleanup.triangles_before, cleanup.triangles_after}},
          {"iou_loss", *worst},
          {"camera", rig.cameras[camera].serial}};
}

HullDoubts doubts_in(const std::map<int, json>& frames, const std::filesystem::path& pictures) {
  HullDoubts doubts;
  std::map<std::string, SilhouetteFault> faults;
  for (const auto& [number, frame] : frames) {
    if (!frame.is_object()) continue;
    doubts.contradictory += !frame.value("trusted", true);
    doubts.cut += frame.value("cut", false);
    std::vector<double> iou;
    const json explained = frame.value("silhouette_iou", json::object());
    for (const json& one : explained)
      if (one.is_number()) iou.push_back(one);
    doubts.poor += recon::poorly_covered(iou);
    if (const json cleanup = frame.value("cleanup", json()); cleanup.is_object())
      add_cost(cleanup, number, doubts.cleanup);
    const json silhouettes = frame.value("silhouettes", json::object());
    for (const auto& [serial, shares] : silhouettes.items()) {
      SilhouetteFault& fault = faults[serial];
      fault.serial = serial;
      ++fault.frames;
      const double lost = shares.value("lost", 0.0), gained = shares.value("gained", 0.0);
      if (fault.frames > 1 && size_of(lost, gained) <= size_of(fault.lost, fault.gained)) continue;
      fault.lost = lost;
      fault.gained = gained;
      fault.worst = number;
    }
  }
  for (auto& [serial, fault] : faults) {
    const std::filesystem::path picture = pictures / picture_name(serial, fault.worst);
    if (is_there(picture)) fault.picture = picture;
    doubts.faults.push_back(std::move(fault));
  }
  std::stable_sort(doubts.faults.begin(), doubts.faults.end(),
                   [](const SilhouetteFault& a, const SilhouetteFault& b) {
                     return size_of(a.lost, a.gained) > size_of(b.lost, b.gained);
                   });
  return doubts;
}

std::string picture_name(const std::string& serial, int frame) { return text(serial, "-", frame, ".png"); }

DoubtPicture picture_of_fault(const std::string& serial, int frame) {
  return {.of = kSilhouettes, .why = "the other cameras contradict it", .cameras = {serial}, .frame = frame};
}

Result<void> keep_pictures(const std::vector<SilhouetteFault>& faults, const std::filesystem::path& folder) {
  std::set<std::string> shown;
  for (const SilhouetteFault& fault : faults) shown.insert(picture_name(fault.serial, fault.worst));
  return DoubtPictures(folder).keep(
      kSilhouettes, [&](const std::string& name, const DoubtPicture&) { return shown.contains(name); });
}

}  // namespace floatstage::pipeline
