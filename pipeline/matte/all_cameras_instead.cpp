#include "pipeline/matte/all_cameras_instead.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <optional>

#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/hull_record.h"
#include "pipeline/matte/camera_key.h"
#include "pipeline/matte/consistent_take.h"
#include "recon/mesh/mesh_silhouettes.h"
#include "recon/silhouette_agreement.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kFewest = 4;    // cameras: two bound a body, and others can deny it
constexpr double kMostDenied = 0.05;  // in the mean of the cameras: what the audit allows a silhouette
constexpr double kBetter = 0.5;       // of what is denied of keys, so much at most of what comes instead,
constexpr double kAlike = 0.01;       // so much more is no worse: pixels of an outline
constexpr double kNotAtAll = 0.25;    // where keys hold as little as that only less

// About any of the take's cameras, whichever are asked for.
Result<bool> somebody_has_a_say(const capture::TakeReader& take, const MatteStore& store,
                                const MatteEdits& edits, const std::vector<MatteJob>& jobs) {
  for (const auto& [serial, of_camera] : edits.cameras)
    if (of_camera != CameraEdits()) return true;
  for (const MatteJob& job : jobs)
    if (!job.guide.empty()) return true;
  for (const RigCamera& camera : take.rig().cameras)
    if (is_folder(take.layout().given_mattes(camera.serial))) return true;
  return anything_given(take, store);
}

// What `auto` came to before, in cameras whose record stands.
std::optional<bool> settled_before(const MatteStore& store, const std::vector<MatteJob>& jobs) {
  for (const auto& [serial, record] : store.record()) {
    const auto job =
        std::find_if(jobs.begin(), jobs.end(), [&](const MatteJob& j) { return j.serial == serial; });
    if (record.how == "auto" && !record.method.empty() && (job == jobs.end() || job->settled))
      return record.method == "consistent";
  }
  return std::nullopt;
}

// The middle one that every camera pictured.
std::optional<int> instant_of(const capture::TakeReader& take) {
  const int count = take.frame_count(), middle = count / 2;
  const auto pictured = [&](int frame) {
    for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
      const std::vector<FrameRow>& rows = take.rows(static_cast<int>(c));
      if (static_cast<std::size_t>(frame) >= rows.size() ||
          !rows[static_cast<std::size_t>(frame)].media_index)
        return false;
    }
    return true;
  };
  std::optional<int> found;
  for (int f = 0; f < count; ++f)
    if ((!found || std::abs(f - middle) < std::abs(*found - middle)) && pictured(f)) found = f;
  return found;
}

struct Keys {
  std::vector<Matte> mattes;    // of each camera what its key tells; empty where there is none
  bool shot_plates_all = true;  // each is a plate that was shot
};

Result<Keys> keys_of(capture::TakeReader& take, int frame, const MatteTakeOptions& options,
                     const std::vector<MatteJob>& jobs) {
  std::vector<Result<Matte>> made(take.rig().cameras.size(), Matte());
  std::vector<char> shot(made.size());
  ProgressPart progress(options.progress, "keys of one instant", made.size());
  parallel_for(made.size(), options.threads, [&](std::size_t c) {
    const auto go_on = [&] { return !is_cancelled(options.progress); };
    if (!go_on()) return;
    const int camera = static_cast<int>(c);
    const Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph) {
      made[c] = forward(photograph);
      return;
    }
    const auto job = std::find_if(jobs.begin(), jobs.end(),
                                  [&](const MatteJob& j) { return j.camera == camera && j.matting; });
    std::optional<CameraKey> key;
    if (job != jobs.end()) {
      key = job->matting->key();
    } else if (Result<CameraKey> other = CameraKey::for_how(take, camera, "auto", {}, {}, go_on)) {
      key = *std::move(other);
    }
    shot[c] = key && key->kind() == CameraKey::Kind::Plate && !key->found();
    if (key && key->kind() != CameraKey::Kind::None)
      if (const Result<Image> alpha = key->key(*photograph, frame); alpha && !alpha->empty())
        made[c] = make_matte({}, *alpha);
    progress.advance();
  });
  if (is_cancelled(options.progress)) return cancelled();
  Keys keys;
  for (Result<Matte>& matte : made) {
    if (!matte) return forward(matte);
    keys.mattes.push_back(coverage(*matte) > 0 ? *std::move(matte) : Matte());
  }
  keys.shot_plates_all = std::all_of(shot.begin(), shot.end(), [](char s) { return s != 0; });
  return keys;
}

// The share of a matte that the hull of all denies, in the mean of the cameras; 1 for one that tells nobody.
double mean_denied(const Rig& rig, const std::vector<Matte>& mattes, int threads) {
  std::vector<double> denied(mattes.size(), 1.0);
  recon::HullOptions options = *hull_options(HullWords());
  options.quality = false;
  options.threads = threads;
  const Result<recon::HullReport> hull = recon::visual_hull(rig, mattes, options);
  if (!hull || hull->mesh.empty()) return 1;
  const recon::MeshSilhouettes silhouettes(hull->mesh);
  parallel_for(mattes.size(), threads, [&](std::size_t c) {
    if (!mattes[c].empty()) denied[c] = recon::denied_share(mattes[c], silhouettes.of(rig.cameras[c]));
  });
  return std::accumulate(denied.begin(), denied.end(), 0.0) / static_cast<double>(denied.size());
}

std::vector<Matte> mattes_of(const std::vector<Image>& alphas) {
  std::vector<Matte> mattes;
  for (const Image& alpha : alphas) {
    Matte matte = alpha.empty() ? Matte() : make_matte({}, alpha);
    mattes.push_back(!matte.empty() && coverage(matte) > 0 ? std::move(matte) : Matte());
  }
  return mattes;
}

}  // namespace

Result<std::string> all_cameras_instead(capture::TakeReader& take, const MatteTakeOptions& options,
                                        const MatteStore& store, const MatteEdits& edits,
                                        const std::vector<MatteJob>& jobs) {
  const std::string no;
  if (std::none_of(jobs.begin(), jobs.end(), [](const MatteJob& job) { return job.undecided(); })) return no;
  constexpr const char* kSaid = "mattes are made by what all cameras say at once, as --matte consistent does";
  if (options.together) return *options.together ? std::string(kSaid) : no;
  if (const std::optional<bool> before = settled_before(store, jobs))
    return *before ? std::string(kSaid) : no;
  const std::size_t cameras = take.rig().cameras.size();
  if (cameras < kFewest) return no;
  const Result<bool> guided = somebody_has_a_say(take, store, edits, jobs);
  if (!guided) return forward(guided);
  if (*guided) return no;
  const std::optional<int> frame = instant_of(take);
  if (!frame) return no;
  const Result<Keys> keys = keys_of(take, *frame, options, jobs);
  if (!keys) return forward(keys);
  const double denied = mean_denied(take.rig(), keys->mattes, options.threads);
  const bool hold = denied < kMostDenied;
  if (hold && !keys->shot_plates_all) return no;
  const Result<ConsistentMattes> instead =
      consistent_instant(take, *frame, options.threads, options.progress);
  if (!instead && instead.error().code == ErrorCode::Cancelled) return forward(instead);
  if (!instead) return no;
  if (hold && !instead->trusted) return no;
  const double instead_denied = mean_denied(take.rig(), mattes_of(instead->mattes), options.threads);
  const double less = denied < kNotAtAll ? kBetter * denied : denied;
  if (hold ? instead_denied > denied + kAlike : instead_denied >= less) return no;
  if (hold)
    return text(
        "frame ", *frame,
        ": plates were shot, and the hull denies hardly more of what all cameras make of them than of "
        "what each makes alone, so ",
        kSaid);
  const auto nobody =
      std::count_if(keys->mattes.begin(), keys->mattes.end(), [](const Matte& m) { return m.empty(); });
  return text("frame ", *frame, ": keys do not hold (they tell nobody in ", nobody, " of ", cameras,
              " cameras, and all cameras together deny ", std::lround(100 * denied), " %), so ", kSaid,
              "; another --matte with --redo makes others");
}

}  // namespace floatstage::pipeline
