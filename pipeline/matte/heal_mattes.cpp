#include "pipeline/matte/heal_mattes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/frame_pixels.h"
#include "core/statistics.h"
#include "core/text.h"
#include "matting/view_cut.h"
#include "pipeline/matte/affected_frames.h"
#include "pipeline/matte/consistent.h"
#include "pipeline/matte/rekey.h"
#include "recon/hull_cover.h"
#include "recon/mesh/mesh_mask.h"
#include "recon/occupancy.h"

namespace floatstage::pipeline {
namespace {

constexpr int kFewWitnesses = 3;   // two bound a body, the third confirms it
constexpr int kManyWitnesses = 8;  // bound it well: as kWitnesses of keyed_witnesses.cpp, one more

constexpr int kWorkingPixels = 100'000, kVoxels = 500'000;  // as ConsistentOptions
constexpr float kSays = 4;           // log-odds of a matte's word, as kColor of consistent.cpp
constexpr double kNearlyAll = 0.75;  // of what the others can say for a place, if none denies it
constexpr double kStandsOut = 2;  // times what cameras lack in the middle: their hull is larger than a body
constexpr double kSameCover = 0.005;

double size_of(double lost, double gained) { return std::max(lost, gained); }

bool believed(const std::vector<Matte>& mattes, std::size_t camera) {
  return !mattes[camera].empty() && coverage(mattes[camera]) > 0;
}

// By camera, how much is wrong with it by the others' word.
std::vector<double> faults_of(const recon::HullReport& hull, std::size_t cameras) {
  std::vector<double> faults(cameras, 0.0);
  for (const recon::SilhouetteVerdict& v : hull.verdicts)
    faults[static_cast<std::size_t>(v.camera)] = size_of(v.lost, v.gained);
  return faults;
}

// By camera, the share of what all others but a few see that its matte lacks, pixel by pixel: what the
// audit's blocks cannot see (a matte full of small holes). Soft, since several may lack something at once.
std::vector<double> missing_of(const Rig& rig, const std::vector<Matte>& mattes,
                               const Eigen::AlignedBox3d& box, int threads) {
  std::vector<Eigen::Vector2i> sizes;
  std::vector<recon::OddsPicture> odds(mattes.size());
  int there = 0;
  for (std::size_t c = 0; c < mattes.size(); ++c) {
    const CameraModel& m = rig.cameras[c].model;
    const double shrink =
        std::min(1.0, std::sqrt(kWorkingPixels / (static_cast<double>(m.width) * m.height)));
    const int w = std::max(1, static_cast<int>(std::lround(shrink * m.width))),
              h = std::max(1, static_cast<int>(std::lround(shrink * m.height)));
    sizes.emplace_back(w, h);
    if (!believed(mattes, c)) continue;
    ++there;
    odds[c] = {w, h, {}};
    for (const std::uint8_t a : matting::shrunk(to_image(mattes[c]), w, h).pixels)
      odds[c].odds.push_back(a >= 128 ? kSays : -kSays);
  }
  recon::OccupancyGrid grid(rig, box, kVoxels, sizes, std::min(2, there), threads);
  const recon::OccupancyOptions options;
  grid.fuse(odds, options);
  const double all = std::log(1 / options.seen_anyway) * (there - 1);
  std::vector<double> missing(mattes.size(), 0.0);
  for (std::size_t c = 0; c < mattes.size(); ++c) {
    if (odds[c].empty()) continue;
    const std::vector<float> others = grid.said_by_others(static_cast<int>(c));
    double seen = 0, lacks = 0;
    for (std::size_t p = 0; p < others.size(); ++p) {
      if (others[p] < kNearlyAll * all + options.prior) continue;
      ++seen;
      lacks += odds[c].odds[p] < 0;
    }
    missing[c] = seen > 0 ? lacks / seen : 0;
  }
  return missing;
}

// Mean share of these cameras' silhouettes that the body explains.
double cover_of(const recon::HullReport& hull, const std::vector<std::size_t>& cameras) {
  double sum = 0;
  for (const std::size_t c : cameras) sum += std::isnan(hull.silhouette_iou[c]) ? 1 : hull.silhouette_iou[c];
  return cameras.empty() ? 0 : sum / static_cast<double>(cameras.size());
}

// Whether a body explains more of these cameras' silhouettes than another, and contradicts no camera more.
bool explains_more(const recon::HullReport& now, const recon::HullReport& before,
                   const std::vector<std::size_t>& witnesses, std::size_t cameras) {
  if (now.contradictory || now.mesh.empty() || cover_of(now, witnesses) <= cover_of(before, witnesses))
    return false;
  const std::vector<double> is = faults_of(now, cameras), was = faults_of(before, cameras);
  return std::equal(is.begin(), is.end(), was.begin(), std::less_equal<>());
}

// What of the new matte the old one lacks, and what of the old one is none.
Healing difference(const Matte& old, const Matte& anew) {
  std::size_t lost = 0, gained = 0, had = 0, has = 0;
  for (int y = 0; y < old.height; ++y)
    for (int x = 0; x < old.width; ++x) {
      const bool was = old.row(y)[x] >= 128, is = anew.row(y)[x] >= 128;
      had += was, has += is;
      lost += is && !was, gained += was && !is;
    }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  };
  return {share(lost, has), share(gained, had), {}};
}

// Whether the camera's matte of these bytes is one that we made.
bool is_ours(const CameraRecord* record, int frame, const std::string& hash) {
  if (!record || record->how == "given") return false;
  const auto file = record->files.find(frame);
  return file != record->files.end() && file->second == hash;
}

Result<Image> photograph(capture::TakeReader& take, std::size_t camera, int frame) {
  Result<Frame> frame_there = take.frame(static_cast<int>(camera), frame);
  if (!frame_there) return forward(frame_there);
  if (frame_there->empty()) return Image();
  return to_rgb(*frame_there);
}

}  // namespace

std::string sentence(const HealedCamera& healed) {
  const auto percent = [](double share) { return std::lround(100 * share); };
  std::string out = text("camera '", healed.serial, "': ", healed.frames,
                         healed.frames == 1 ? " matte was" : " mattes were",
                         " cut anew by what the others see; that of frame ", healed.worst);
  if (healed.lost >= 1) return out + " was missing";
  if (healed.lost >= healed.gained) return text(out, " lacked ", percent(healed.lost), " % of it");
  return text(out, " showed ", percent(healed.gained), " % of subject that no other confirmed");
}

bool is_persons(const CameraRecord& record, int frame) {
  const auto f = static_cast<std::size_t>(frame);
  if (record.key != "cut" && (record.method == "key" || record.method == "closed-form")) {
    const CameraEdits masks{{}, record.edits.masks};
    return record.guided.contains(frame) || edited_frames({}, masks, frame + 1)[f];
  }
  return downstream_of(frames_made_otherwise(record.method, record.key, {}, record.edits, frame + 1),
                       record.edits)[f];
}

Result<std::unique_ptr<MatteHealer>> MatteHealer::open(capture::TakeReader& take) {
  Result<std::unique_ptr<MatteStore>> store = MatteStore::open(take.layout());
  if (!store) return forward(store);
  return std::unique_ptr<MatteHealer>(new MatteHealer(take, std::move(*store)));
}

// Whether the matte is ours to make: the record has it, or has the camera and no matte is there.
Result<bool> MatteHealer::ours(const std::string& serial, int frame, bool there) {
  const std::lock_guard lock(mutex_);
  const CameraRecord* record = store_->find(serial);
  if (!record || record->how == "given") return false;
  if (is_persons(*record, frame)) return false;
  const Result<MatteOrigin> origin = store_->origin(serial, frame);
  if (!origin) return forward(origin);
  return *origin == (there ? MatteOrigin::Ours : MatteOrigin::Missing);
}

// What strokes of the frame mark is as it was.
void MatteHealer::hold(std::size_t camera, int frame, const Matte& matte, Matte& anew) {
  std::vector<MatteStroke> strokes;
  {
    const std::lock_guard lock(mutex_);
    if (const CameraRecord* record = store_->find(take_.rig().cameras[camera].serial))
      for (const MatteKeyframe& keyframe : record->edits.keyframes)
        if (keyframe.frame == frame) strokes = keyframe.strokes;
  }
  if (strokes.empty() || matte.empty() || anew.empty()) return;
  Image said(matte.width, matte.height, 1, 128), out = to_image(anew);
  paint_strokes(strokes, 1, said);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      if (*said.at(x, y) != 128) *out.at(x, y) = matte.row(y)[x];
  anew = make_matte(anew.source, out);
}

Result<std::vector<MatteHealer::Patient>> MatteHealer::patients(int frame, const recon::HullReport& hull,
                                                                const std::vector<Matte>& mattes,
                                                                int threads) {
  std::vector<Patient> found;
  if (store_->record().empty()) return found;  // nothing is ours: who is ill is no question
  for (const recon::SilhouetteVerdict& v : hull.verdicts)
    found.push_back({static_cast<std::size_t>(v.camera), {v.lost, v.gained, {}}});
  if (found.empty() && recon::poorly_covered(hull.silhouette_iou) && !hull.searched.isEmpty()) {
    const std::vector<double> missing = missing_of(take_.rig(), mattes, hull.searched, threads);
    std::vector<double> known;
    for (std::size_t c = 0; c < mattes.size(); ++c)
      if (believed(mattes, c)) known.push_back(missing[c]);
    for (std::size_t c = 0; c < mattes.size(); ++c)
      if (believed(mattes, c) && missing[c] > kStandsOut * median(known))
        found.push_back({c, {missing[c], 0, {}}});
    if (found.size() > known.size() / 4) found.clear();  // a majority's word, or a calibration's
  }
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (mattes[c].empty()) found.push_back({c, {1, 0, {}}});
  std::vector<Patient> treated;
  for (const Patient& p : found) {
    const Result<bool> may = ours(take_.rig().cameras[p.camera].serial, frame, !mattes[p.camera].empty());
    if (!may) return forward(may);
    if (*may) treated.push_back(p);
  }
  return treated;
}

// All mattes of the instant with those of the patients cut anew; nothing when the others cannot tell.
Result<std::vector<Matte>> MatteHealer::cut_anew(int frame, const std::vector<Patient>& patients,
                                                 const recon::HullOptions& options,
                                                 const std::vector<Matte>& mattes) {
  std::vector<Matte> others = mattes;
  for (const Patient& p : patients) others[p.camera] = {};
  std::vector<Witness> witnesses;
  for (std::size_t c = 0; c < others.size(); ++c) {
    if (!believed(others, c)) continue;
    Result<Image> picture = photograph(take_, c, frame);
    if (!picture) return forward(picture);
    if (!picture->empty()) witnesses.push_back({std::move(*picture), others[c]});
  }
  if (witnesses.size() < kFewWitnesses) return std::vector<Matte>();
  const Result<recon::HullReport> hull = recon::visual_hull(take_.rig(), others, options);
  if (!hull || hull->mesh.empty() || hull->contradictory) return std::vector<Matte>();
  for (const Patient& p : patients) {
    Result<Image> picture = photograph(take_, p.camera, frame);
    if (!picture) return forward(picture);
    if (picture->empty()) continue;
    const Matte seen = recon::mesh_mask(take_.rig().cameras[p.camera], hull->mesh);
    Result<Image> cut = rekey(*picture, seen, witnesses, {.threads = options.threads});
    if (!cut) continue;  // the others' body is not in the picture, or fills it
    others[p.camera] = make_matte(mattes[p.camera].source, *cut);
    hold(p.camera, frame, mattes[p.camera], others[p.camera]);
  }
  for (const Patient& p : patients)
    if (others[p.camera].empty()) others[p.camera] = mattes[p.camera];
  return others;
}

// A camera that nobody accuses any more once the others are healed keeps its matte.
void MatteHealer::spare(std::vector<Patient>& patients, const recon::HullOptions& options,
                        const std::vector<std::size_t>& witnesses, const std::vector<Matte>& mattes,
                        std::vector<Matte>& anew, recon::HullReport& after) {
  std::sort(patients.begin(), patients.end(), [](const Patient& a, const Patient& b) {
    return size_of(a.before.lost, a.before.gained) < size_of(b.before.lost, b.before.gained);
  });
  for (std::size_t i = 0; i + 1 < patients.size();) {
    const std::size_t c = patients[i].camera;
    std::vector<Matte> kept = anew;
    kept[c] = mattes[c];
    Result<recon::HullReport> hull = mattes[c].empty()
                                         ? Result<recon::HullReport>(fail(ErrorCode::NotFound, ""))
                                         : recon::visual_hull(take_.rig(), kept, options);
    if (!hull || hull->verdicts.size() > after.verdicts.size() ||
        cover_of(*hull, witnesses) < cover_of(after, witnesses) - kSameCover) {
      ++i;
      continue;
    }
    anew = std::move(kept);
    after = std::move(*hull);
    patients.erase(patients.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

bool MatteHealer::compared(int frame, const MatteHashes& hashes) {
  const std::string instant = hash_of_instant(hashes);
  const std::lock_guard lock(mutex_);
  return std::all_of(hashes.begin(), hashes.end(), [&](const auto& matte) {
    const CameraRecord* record = store_->find(matte.first);
    if (!is_ours(record, frame, matte.second)) return true;
    const auto before = record->compared.find(frame);
    return before != record->compared.end() && before->second == instant;
  });
}

Result<bool> MatteHealer::heal(int frame, const recon::HullReport& hull, const recon::HullOptions& options,
                               std::vector<Matte>& mattes, MatteHashes& hashes) {
  if (options.voting != recon::HullVoting::Auto || compared(frame, hashes)) return false;
  const std::vector<Matte> before = mattes;
  const Result<bool> healed = look(frame, hull, options, mattes);
  if (!healed) return forward(healed);
  const std::lock_guard lock(mutex_);
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (mattes[c].alpha != before[c].alpha) {
      const std::string& serial = take_.rig().cameras[c].serial;
      hashes[serial] = store_->find(serial)->files.at(frame);
    }
  const std::string instant = hash_of_instant(hashes);
  for (const auto& [serial, hash] : hashes)
    if (is_ours(store_->find(serial), frame, hash)) {
      store_->camera(serial).compared[frame] = instant;
      touched_.insert(serial);
    }
  return healed;
}

// Treats the accused, and weighs keys.
Result<bool> MatteHealer::look(int frame, const recon::HullReport& hull, const recon::HullOptions& options,
                               std::vector<Matte>& mattes) {
  if (hull.contradictory) return false;
  std::vector<bool> keys(mattes.size());  // what others' evidence made is a key no more
  for (std::size_t c = 0; c < mattes.size(); ++c) keys[c] = by_colour(take_.rig().cameras[c].serial, frame);
  recon::HullOptions quick = options;
  quick.quality = true;
  quick.cleanup = {};
  const Result<bool> treated = treat(frame, hull, quick, mattes);
  if (!treated) return forward(treated);
  if (!recon::leaves_much_open(hull)) return treated;
  Result<recon::HullReport> now = recon::HullReport();
  if (*treated) now = recon::visual_hull(take_.rig(), mattes, quick);
  if (!now || (*treated && !recon::leaves_much_open(*now))) return treated;
  if (const Result<bool> may = may_heal(); !may || !*may) return may;
  const Result<bool> weighed = weigh(frame, *treated ? *now : hull, quick, keys, mattes);
  if (!weighed) return forward(weighed);
  return *treated || *weighed;
}

// Mattes that the others accuse, cut anew.
Result<bool> MatteHealer::treat(int frame, const recon::HullReport& hull, const recon::HullOptions& quick,
                                std::vector<Matte>& mattes) {
  Result<std::vector<Patient>> patients = this->patients(frame, hull, mattes, quick.threads);
  if (!patients) return forward(patients);
  if (patients->empty()) return false;
  if (const Result<bool> may = may_heal(); !may || !*may) return may;
  Result<std::vector<Matte>> anew = cut_anew(frame, *patients, quick, mattes);
  if (!anew) return forward(anew);
  if (anew->empty()) return false;
  Result<recon::HullReport> after = recon::visual_hull(take_.rig(), *anew, quick);
  if (!after || after->contradictory || after->mesh.empty()) return false;
  std::vector<std::size_t> witnesses;
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (believed(mattes, c) &&
        std::none_of(patients->begin(), patients->end(), [&](const Patient& p) { return p.camera == c; }))
      witnesses.push_back(c);
  const std::vector<double> before = faults_of(hull, mattes.size()), now = faults_of(*after, mattes.size());
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (now[c] > before[c]) return false;  // a body that others now contradict is no cure
  if (recon::poorly_covered(after->silhouette_iou)) return false;
  spare(*patients, quick, witnesses, mattes, *anew, *after);
  return keep(frame, *patients, witnesses, faults_of(*after, mattes.size()), before, *anew, mattes);
}

// Writes the new mattes of which the others believe more than of the old ones.
Result<bool> MatteHealer::keep(int frame, const std::vector<Patient>& patients,
                               const std::vector<std::size_t>& witnesses, const std::vector<double>& now,
                               const std::vector<double>& before, std::vector<Matte>& anew,
                               std::vector<Matte>& mattes) {
  std::vector<std::string> by;
  for (const std::size_t c : witnesses) by.push_back(take_.rig().cameras[c].serial);
  bool any = false;
  for (const Patient& p : patients) {
    const std::size_t c = p.camera;
    if (anew[c].empty() || (before[c] > 0 && now[c] >= before[c])) continue;
    Healing healing = p.before;
    healing.by = by;
    const Result<bool> ok = replace(c, frame, std::move(healing), std::move(anew[c]), mattes[c]);
    if (!ok) return forward(ok);
    any = true;
  }
  return any;
}

// Writes a camera's new matte, and remembers what was wrong with the old one.
Result<bool> MatteHealer::replace(std::size_t camera, int frame, Healing healing, Matte anew, Matte& matte) {
  const std::string& serial = take_.rig().cameras[camera].serial;
  if (Result<bool> ok = store_->put(serial, frame, to_image(anew), healing); !ok) return forward(ok);
  const std::lock_guard lock(mutex_);
  touched_.insert(serial);
  HealedCamera& healed = healed_[serial];
  if (matte.empty()) healed.filled.push_back(frame);
  matte = std::move(anew);
  const double size = size_of(healing.lost, healing.gained), most = size_of(healed.lost, healed.gained);
  if (healed.frames++ == 0 || size > most || (size == most && frame < healed.worst))
    healed.worst = frame, healed.lost = healing.lost, healed.gained = healing.gained;
  return true;
}

// Whether the key took colours for evidence, as the weighing does; a plate knows more of each place. Not of
// a matte that the others' evidence made before.
bool MatteHealer::by_colour(const std::string& serial, int frame) {
  const std::lock_guard lock(mutex_);
  const CameraRecord* record = store_->find(serial);
  return record && !record->healed.contains(frame) &&
         (record->key.starts_with("chroma") || record->key.starts_with("luminance"));
}

// All keys by colour, where many are a little wrong, against colours and what all cameras see. Kept when the
// body then explains more of the silhouettes and contradicts no camera more than before.
Result<bool> MatteHealer::weigh(int frame, const recon::HullReport& hull, const recon::HullOptions& quick,
                                const std::vector<bool>& by_key, std::vector<Matte>& mattes) {
  std::vector<Image> pictures(mattes.size()), keys(mattes.size());
  std::vector<std::size_t> witnesses, keyed;
  for (std::size_t c = 0; c < mattes.size(); ++c) {
    if (!believed(mattes, c)) continue;
    witnesses.push_back(c);
    const std::string& serial = take_.rig().cameras[c].serial;
    const Result<bool> may = by_key[c] ? ours(serial, frame, true) : false;
    if (!may) return forward(may);
    if (*may) keyed.push_back(c);
  }
  if (witnesses.size() < kManyWitnesses || keyed.empty()) return false;
  for (const std::size_t c : witnesses) {
    Result<Image> picture = photograph(take_, c, frame);
    if (!picture) return forward(picture);
    if (!picture->empty()) keys[c] = to_image(mattes[c]);
    pictures[c] = std::move(*picture);
  }
  Result<ConsistentMatting> matting = ConsistentMatting::create(take_.rig(), {.threads = quick.threads});
  if (!matting) return false;  // cameras that share no view tell nothing of one another
  const Result<ConsistentMattes> made = matting->reconcile(pictures, keys);
  if (!made || !made->trusted) return false;
  std::vector<Matte> anew = mattes;
  for (const std::size_t c : keyed)
    if (!made->mattes[c].empty()) {
      anew[c] = make_matte(mattes[c].source, made->mattes[c]);
      hold(c, frame, mattes[c], anew[c]);
    }
  const Result<recon::HullReport> after = recon::visual_hull(take_.rig(), anew, quick);
  if (!after || !explains_more(*after, hull, witnesses, mattes.size())) return false;
  std::vector<std::string> by;
  for (const std::size_t c : witnesses) by.push_back(take_.rig().cameras[c].serial);
  bool any = false;
  for (const std::size_t c : keyed) {
    if (made->mattes[c].empty() || to_image(anew[c]).pixels == keys[c].pixels) continue;
    Healing healing = difference(mattes[c], anew[c]);
    healing.by = by;
    const Result<bool> ok = replace(c, frame, std::move(healing), std::move(anew[c]), mattes[c]);
    if (!ok) return forward(ok);
    any = true;
  }
  return any;
}

Result<std::vector<HealedCamera>> MatteHealer::finish() {
  std::vector<HealedCamera> all;
  for (auto& [serial, camera] : healed_) {
    camera.serial = serial;
    all.push_back(camera);
  }
  if (!touched_.empty())
    if (Result<void> ok = store_->save({touched_.begin(), touched_.end()}); !ok) return forward(ok);
  std::stable_sort(all.begin(), all.end(), [](const HealedCamera& a, const HealedCamera& b) {
    return size_of(a.lost, a.gained) > size_of(b.lost, b.gained);
  });
  return all;
}

}  // namespace floatstage::pipeline
