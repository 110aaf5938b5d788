// Method:  labels of several subjects, followed in space and cut in pictures, in turns
// Paper:   Y. Boykov, O. Veksler, R. Zabih, PAMI 2001, for the energies; X. Bai et al., SIGGRAPH 2009, for
//          colours in local windows
// Differs: the hint of where a label is comes from voxels of the hull, which know who hides whom
// ADR:     0298

#include "pipeline/matte/label_follower.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/frame.h"
#include "core/parallel.h"
#include "core/text.h"
#include "matting/labels/label_split.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

using Costs = recon::LabelVolume::Costs;

constexpr int kVoxels = 400'000;  // in the box of the first hull
constexpr float kStep = 2;        // edges that a label's surface moves unforeseen, as a rule: one nat
constexpr float kMostAway = 6;    // nats: what is further off is no unlikelier
constexpr float kNobody = 3;      // nats that it costs to be nobody's
constexpr float kConfirms = 1, kDenies = 3;  // nats by which a pixel's label speaks for a voxel, or against
constexpr double kSmooth = 0.7;              // nats, two neighbours of different labels
constexpr int kBeginRounds = 4, kStepRounds = 2, kLooks = 3;
constexpr double kFade = 0.9;          // of colours, a frame
constexpr double kInertia = 0.5;       // of motion
constexpr int kNear = 3;               // edges between voxels of labels that are one body to the cameras
constexpr double kApart = 0.3;         // of a label near another: colours are learnt below that …
constexpr double kMerged = 0.6;        // … and above that space does not tell them apart
constexpr double kAlike = 0.85;        // Bhattacharyya: colours that do not tell either
constexpr double kMeets = 0.7;         // IoU with which labels from two frames must meet
constexpr double kLeastOfSum = 0.005;  // of the sum: less is lost

Image photograph(capture::TakeReader& take, std::size_t camera, int frame, Result<void>& ok) {
  Result<Frame> there = take.frame(static_cast<int>(camera), frame);
  if (!there) {
    ok = forward(there);
    return {};
  }
  if (there->empty()) return {};
  Result<Image> rgb = to_rgb(*there);
  if (!rgb) ok = forward(rgb);
  return rgb ? std::move(*rgb) : Image();
}

std::vector<Matte> as_mattes(const std::vector<Image>& images) {
  std::vector<Matte> mattes;
  for (const Image& i : images) mattes.push_back(i.empty() ? Matte() : make_matte({}, i));
  return mattes;
}

long pixels_of(const Image& labels, int label) {
  return static_cast<long>(
      std::count(labels.pixels.begin(), labels.pixels.end(), static_cast<std::uint8_t>(label)));
}

}  // namespace

LabelFollower::LabelFollower(capture::TakeReader& take, const LabelRecord& record, const LabelGivens& givens,
                             int threads)
    : take_(take),
      names_(record.labels),
      givens_(givens),
      threads_(threads),
      palette_(static_cast<int>(record.labels.size())) {}

Result<void> LabelFollower::run(const Done& done) {
  const int last = take_.frame_count() - 1;
  std::optional<LabelInstant> before;  // of the key frame before, walked on to the middle
  for (auto key = givens_.begin(); key != givens_.end(); ++key) {
    const int from = key == givens_.begin() ? 0 : (std::prev(key)->first + key->first) / 2 + 1,
              to = std::next(key) == givens_.end() ? last : (key->first + std::next(key)->first) / 2;
    Result<LabelInstant> here = begin(key->first);
    if (!here) return forward(here);
    if (Result<void> ok = done(*here); !ok) return ok;
    LabelInstant end = *here;
    if (Result<void> ok = walk(*here, from, done, end); !ok) return ok;
    if (before) {
      Result<LabelInstant> meets =
          end.frame == before->frame ? Result<LabelInstant>(end) : step(end, before->frame);
      if (!meets) return forward(meets);
      doubt_meeting(*before, *meets);
    }
    end = *here;
    if (Result<void> ok = walk(*here, to, done, end); !ok) return ok;
    before = std::move(end);
  }
  return {};
}

// From an instant to `end`, whose instant is `last` then; without the first.
Result<void> LabelFollower::walk(const LabelInstant& from, int end, const Done& done, LabelInstant& last) {
  last = from;
  const int by = end < from.frame ? -1 : 1;
  for (int frame = from.frame; frame != end;) {
    Result<LabelInstant> next = step(last, frame += by);
    if (!next) return forward(next);
    doubt_loss(*next);
    doubt_merge(*next);
    last = std::move(*next);
    if (Result<void> ok = done(last); !ok) return ok;
  }
  return {};
}

Result<LabelInstant> LabelFollower::open(int frame) const {
  LabelInstant instant;
  instant.frame = frame;
  const std::size_t cameras = take_.rig().cameras.size();
  Result<std::vector<Matte>> mattes = load_mattes(take_, frame);
  if (!mattes) return forward(mattes);
  instant.pictures.resize(cameras);
  instant.mattes.resize(cameras);
  instant.labels.resize(cameras);
  instant.sure.resize(cameras);
  std::vector<Result<void>> read(cameras);
  parallel_for(cameras, threads_, [&](std::size_t c) {
    if ((*mattes)[c].empty()) return;
    instant.pictures[c] = photograph(take_, c, frame, read[c]);
    if (!instant.pictures[c].empty()) instant.mattes[c] = to_image((*mattes)[c]);
  });
  for (const Result<void>& ok : read)
    if (!ok) return forward(ok);
  return instant;
}

// Nothing where there is nobody, or, if it is not `needed`, where silhouettes bound nothing.
Result<std::optional<recon::LabelVolume>> LabelFollower::volume_of(const LabelInstant& instant, bool needed) {
  const std::vector<Matte> mattes = as_mattes(instant.mattes);
  if (voxel_ == 0) voxel_ = recon::LabelVolume::edge_for(take_.rig(), mattes, kVoxels);
  Result<recon::LabelVolume> volume =
      voxel_ > 0
          ? recon::LabelVolume::carve(take_.rig(), mattes, voxel_, static_cast<int>(names_.size()), threads_)
          : fail(ErrorCode::BadData, "the silhouettes bound nothing");
  if (volume && volume->size() > 0) return std::optional(std::move(*volume));
  if (!needed) return std::optional<recon::LabelVolume>();
  return fail(ErrorCode::BadData,
              text("frame ", instant.frame, ": ",
                   volume ? "the silhouettes have no point in common" : volume.error().message,
                   "; labels need mattes of calibrated cameras that agree"));
}

Result<LabelInstant> LabelFollower::begin(int frame) {
  Result<LabelInstant> instant = open(frame);
  if (!instant) return instant;
  for (const auto& [camera, may] : givens_.at(frame))
    if (instant->mattes[static_cast<std::size_t>(camera)].empty())
      return fail(ErrorCode::NotFound,
                  text("camera '", take_.rig().cameras[static_cast<std::size_t>(camera)].serial,
                       "' has no matte of frame ", frame,
                       ", of which a label was given; run `floatstage matte` without labels first"));
  Result<std::optional<recon::LabelVolume>> volume = volume_of(*instant, true);
  if (!volume) return forward(volume);
  const Costs costs = begin_costs(**volume, *instant);
  const std::vector<std::uint8_t> voxels = settle(**volume, costs, nullptr, kBeginRounds, *instant);
  finish(**volume, voxels, nullptr, *instant);
  return instant;
}

// Voxels that somebody pointed at, and the ways from there.
Costs LabelFollower::begin_costs(const recon::LabelVolume& volume, const LabelInstant& instant) const {
  const std::size_t labels = names_.size();
  std::vector<std::vector<std::size_t>> start(labels);
  for (const auto& [camera, may] : givens_.at(instant.frame)) {
    const Image& matte = instant.mattes[static_cast<std::size_t>(camera)];
    const int step = std::max(1, volume.cell(camera) / 2);
    Image asked(matte.width, matte.height, 1);
    std::vector<float> says(matte.pixels.size() * labels, 0.F);
    for (std::size_t p = 0; p < may.size(); ++p)
      if (std::popcount(may[p]) == 1 && matte.pixels[p] >= 128) asked.pixels[p] = 1;
    for (int y = 0; y < matte.height; ++y)
      for (int x = 0; x < matte.width; ++x) {
        const std::size_t p = matte.offset(x, y);
        // A few pixels of a click are seen whole, masks on a grid.
        if (!asked.pixels[p] || (x % step && x > 0 && asked.pixels[p - 1]) ||
            (y % step && y > 0 && *asked.at(x, y - 1)))
          continue;
        const std::size_t v = volume.seen_at(camera, x, y);
        if (v < volume.size()) start[static_cast<std::size_t>(std::countr_zero(may[p]))].push_back(v);
      }
  }
  std::vector<std::vector<float>> way;
  for (const std::vector<std::size_t>& from : start) way.push_back(volume.way_from(from));
  Costs costs = volume.no_costs();
  for (std::size_t v = 0; v < volume.size(); ++v) {
    float least = recon::LabelVolume::kFar;
    for (const std::vector<float>& w : way) least = std::min(least, w[v]);
    const bool reached = least < recon::LabelVolume::kFar;
    float* of = costs.data() + v * (labels + 1);
    of[0] = reached ? kNobody : 0;
    for (std::size_t l = 0; l < labels; ++l)
      of[l + 1] = reached ? std::min((way[l][v] - least) / kStep, kMostAway) : kNobody;
  }
  return costs;
}

Costs LabelFollower::carried_costs(const recon::LabelVolume& volume, const LabelInstant& from) const {
  const std::size_t labels = names_.size();
  Costs costs = volume.no_costs();
  for (std::size_t v = 0; v < volume.size(); ++v) costs[v * (labels + 1)] = kNobody;
  for (std::size_t l = 0; l < labels; ++l) {
    std::vector<Eigen::Vector3i> moved;
    const Eigen::Vector3i by = from.motion[l].array().round().cast<int>();
    for (const Eigen::Vector3i& p : from.places[l]) moved.emplace_back(p + by);
    const std::vector<float> away = volume.distance_to(moved);
    for (std::size_t v = 0; v < volume.size(); ++v)
      costs[v * (labels + 1) + l + 1] = std::min(away[v] / kStep, kMostAway);
  }
  return costs;
}

// What pictures say of voxels: once they are cut, by their labels; before, by colours anywhere.
void LabelFollower::hear(const recon::LabelVolume& volume, const LabelInstant& instant,
                         const std::vector<std::uint8_t>& voxels, Costs& costs) const {
  const std::size_t labels = names_.size();
  for (std::size_t c = 0; c < instant.mattes.size(); ++c) {
    const Image& matte = instant.mattes[c];
    if (matte.empty()) continue;
    std::vector<float> says(matte.pixels.size() * labels, 0.F);
    for (std::size_t p = 0; p < matte.pixels.size(); ++p) {
      if (matte.pixels[p] < 128) continue;
      const std::span<float> said(says.data() + p * labels, labels);
      if (instant.labels[c].empty()) {
        palette_.odds(instant.pictures[c].pixels.data() + 3 * p, said);
        for (float& s : said) s = s > 0 ? s / 2 : s;
      } else if (const int l = instant.labels[c].pixels[p]; l > 0) {
        std::fill(said.begin(), said.end(), -kDenies);
        said[static_cast<std::size_t>(l - 1)] = kConfirms;
      }
    }
    volume.hear(static_cast<int>(c), voxels, says, 1, costs);
  }
}

void LabelFollower::split(const recon::LabelVolume& volume, const std::vector<std::uint8_t>& voxels,
                          const LabelInstant* near, LabelInstant& instant) const {
  const auto given = givens_.find(instant.frame);
  parallel_for(instant.mattes.size(), threads_, [&](std::size_t c) {
    if (instant.mattes[c].empty()) return;
    const int camera = static_cast<int>(c);
    const Image hint = volume.picture(camera, voxels);
    std::vector<Image> where;
    for (std::size_t l = 1; l <= names_.size(); ++l) {
      std::vector<std::uint8_t> only = voxels;
      for (std::uint8_t& v : only) v = v == l;
      where.push_back(volume.picture(camera, only));
    }
    instant.sure[c] = Image(hint.width, hint.height, 1);
    for (std::size_t p = 0; p < hint.pixels.size(); ++p) {
      const auto there =
          std::count_if(where.begin(), where.end(), [&](const Image& w) { return w.pixels[p] != 0; });
      if (there == 1) instant.sure[c].pixels[p] = hint.pixels[p];
    }
    const LabelsAllowed* may = nullptr;
    if (given != givens_.end())
      if (const auto of = given->second.find(camera); of != given->second.end()) may = &of->second;
    const bool known = near && !near->labels[c].empty();
    instant.labels[c] = matting::split_labels({.picture = instant.pictures[c],
                                               .matte = instant.mattes[c],
                                               .hint = hint,
                                               .where = where,
                                               .slack = std::max(3.0, 1.0 * volume.cell(camera)),
                                               .labels = static_cast<int>(names_.size()),
                                               .may = may ? *may : anything_,
                                               .palette = palette_,
                                               .near_picture = known ? &near->pictures[c] : nullptr,
                                               .near_labels = known ? &near->labels[c] : nullptr});
  });
}

// Space and pictures in turns.
std::vector<std::uint8_t> LabelFollower::settle(const recon::LabelVolume& volume, const Costs& costs,
                                                const LabelInstant* near, int rounds, LabelInstant& instant) {
  std::vector<std::uint8_t> voxels;
  for (int round = 0; round < rounds; ++round) {
    // What contradicts its pixels becomes nobody's, and shows what is behind it.
    for (int look = 0; look < (round > 0 || near ? kLooks : 1); ++look) {
      Costs heard = costs;
      if (round > 0 || near) hear(volume, instant, voxels, heard);
      voxels = volume.label(heard, kSmooth);
    }
    split(volume, voxels, near, instant);
    if (near) continue;
    palette_ = matting::LabelPalette(static_cast<int>(names_.size()));
    for (std::size_t c = 0; c < instant.labels.size(); ++c)
      if (!instant.sure[c].empty()) palette_.learn(instant.pictures[c], instant.mattes[c], instant.sure[c]);
  }
  return voxels;
}

Result<LabelInstant> LabelFollower::step(const LabelInstant& from, int frame) {
  Result<LabelInstant> instant = open(frame);
  if (!instant) return instant;
  Result<std::optional<recon::LabelVolume>> volume = volume_of(*instant, false);
  if (!volume) return forward(volume);
  if (!*volume) {
    split_alone(from, *instant);
    return instant;
  }
  const Costs costs = carried_costs(**volume, from);
  const std::vector<std::uint8_t> voxels = settle(**volume, costs, &from, kStepRounds, *instant);
  finish(**volume, voxels, &from, *instant);
  return instant;
}

// Where space says nothing, each picture alone, from the one beside it.
void LabelFollower::split_alone(const LabelInstant& from, LabelInstant& instant) const {
  instant.places = from.places;
  instant.motion = from.motion;
  for (std::size_t c = 0; c < instant.mattes.size(); ++c) {
    if (instant.mattes[c].empty()) continue;
    const bool known = !from.labels[c].empty();
    const Image nothing(instant.mattes[c].width, instant.mattes[c].height, 1);
    const Image& hint = known ? from.labels[c] : nothing;
    std::vector<Image> where(names_.size(), nothing);
    for (std::size_t p = 0; p < hint.pixels.size(); ++p)
      if (hint.pixels[p] > 0) where[hint.pixels[p] - 1U].pixels[p] = 255;
    instant.labels[c] = matting::split_labels({.picture = instant.pictures[c],
                                               .matte = instant.mattes[c],
                                               .hint = hint,
                                               .where = where,
                                               .labels = static_cast<int>(names_.size()),
                                               .may = anything_,
                                               .palette = palette_,
                                               .near_picture = known ? &from.pictures[c] : nullptr,
                                               .near_labels = known ? &from.labels[c] : nullptr});
  }
}

// Where labels are and move, and, while they are apart, their colours.
void LabelFollower::finish(const recon::LabelVolume& volume, const std::vector<std::uint8_t>& voxels,
                           const LabelInstant* from, LabelInstant& instant) {
  const auto middle = [](const std::vector<Eigen::Vector3i>& places) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3i& p : places) sum += p.cast<double>();
    return Eigen::Vector3d(sum / std::max<double>(1, static_cast<double>(places.size())));
  };
  instant.places.resize(names_.size());
  instant.motion.assign(names_.size(), Eigen::Vector3d::Zero());
  for (std::size_t v = 0; v < voxels.size(); ++v)
    if (voxels[v] > 0) instant.places[voxels[v] - 1U].push_back(volume.places()[v]);
  for (std::size_t l = 0; l < names_.size() && from; ++l) {
    if (instant.places[l].empty() && !from->places[l].empty()) {
      instant.places[l] = from->places[l];
      continue;
    }
    const Eigen::Vector3d now = middle(instant.places[l]) - middle(from->places[l]);
    instant.motion[l] = kInertia * from->motion[l] + (1 - kInertia) * now;
  }
  for (const double share : volume.merged(voxels, kNear)) instant.merged = std::max(instant.merged, share);
  if (!from || instant.merged > kApart) return;
  palette_.fade(kFade);
  for (std::size_t c = 0; c < instant.labels.size(); ++c)
    if (!instant.sure[c].empty()) palette_.learn(instant.pictures[c], instant.mattes[c], instant.sure[c]);
}

void LabelFollower::doubt(const std::string& why, const std::string& serial, int frame) {
  for (LabelDoubt& d : doubts_)
    if (d.why == why) {
      ++d.frames;
      if (frame < d.frame) d.frame = frame, d.serial = serial;
      return;
    }
  doubts_.push_back({why, serial, frame});
}

// The camera that shows least of a label, of those that show any of the sum.
int LabelFollower::most_hidden(const LabelInstant& instant, int label) const {
  int camera = 0;
  double least = 2;
  for (std::size_t c = 0; c < instant.labels.size(); ++c) {
    if (instant.labels[c].empty()) continue;
    const long none = pixels_of(instant.labels[c], 0),
               all = static_cast<long>(instant.labels[c].pixels.size()) - none;
    const double share =
        all > 0 ? static_cast<double>(pixels_of(instant.labels[c], label)) / static_cast<double>(all) : 2;
    if (share < least) least = share, camera = static_cast<int>(c);
  }
  return camera;
}

void LabelFollower::doubt_merge(const LabelInstant& instant) {
  if (instant.merged <= kMerged) return;
  for (int a = 1; a <= static_cast<int>(names_.size()); ++a)
    for (int b = a + 1; b <= static_cast<int>(names_.size()); ++b)
      if (palette_.alike(a, b) > kAlike)
        doubt(
            text("'", names_[static_cast<std::size_t>(a - 1)], "' and '",
                 names_[static_cast<std::size_t>(b - 1)],
                 "' are one body to all cameras there and have the same colours, so that they may have been "
                 "exchanged from then on; give a mask or a click of each after it"),
            take_.rig().cameras[static_cast<std::size_t>(most_hidden(instant, a))].serial, instant.frame);
}

void LabelFollower::doubt_loss(const LabelInstant& instant) {
  std::vector<long> of(names_.size() + 1, 0);
  for (const Image& labels : instant.labels)
    for (std::size_t l = 0; l < of.size(); ++l)
      if (!labels.empty()) of[l] += pixels_of(labels, static_cast<int>(l));
  long all = 0;
  for (std::size_t l = 1; l < of.size(); ++l) all += of[l];
  for (std::size_t l = 1; l < of.size(); ++l)
    if (all > 0 && static_cast<double>(of[l]) < kLeastOfSum * static_cast<double>(all))
      doubt(text("nothing is left of '", names_[l - 1],
                 "' in any camera; if that is wrong, give a mask or a click of it there"),
            take_.rig().cameras[static_cast<std::size_t>(most_hidden(instant, static_cast<int>(l)))].serial,
            instant.frame);
}

void LabelFollower::doubt_meeting(const LabelInstant& onward, const LabelInstant& backward) {
  for (int l = 1; l <= static_cast<int>(names_.size()); ++l) {
    double least = kMeets;
    int camera = -1;
    for (std::size_t c = 0; c < onward.labels.size(); ++c) {
      if (onward.labels[c].empty() || backward.labels[c].empty()) continue;
      long both = 0, either = 0;
      for (std::size_t p = 0; p < onward.labels[c].pixels.size(); ++p) {
        const bool a = onward.labels[c].pixels[p] == l, b = backward.labels[c].pixels[p] == l;
        both += a && b, either += a || b;
      }
      if (either > 0 && static_cast<double>(both) < least * static_cast<double>(either))
        least = static_cast<double>(both) / static_cast<double>(either), camera = static_cast<int>(c);
    }
    if (camera >= 0)
      doubt(text("'", names_[static_cast<std::size_t>(l - 1)],
                 "' is not the same when it is followed from the frames given before and after; give a mask "
                 "or a "
                 "click of each label there"),
            take_.rig().cameras[static_cast<std::size_t>(camera)].serial, onward.frame);
  }
}

}  // namespace floatstage::pipeline
