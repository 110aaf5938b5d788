// Method:  labels of several subjects, followed in space and cut in pictures, in turns
// Paper:   Y. Boykov, O. Veksler, R. Zabih, PAMI 2001, for the energies; X. Bai et al., SIGGRAPH 2009, for
//          colours in local windows
// Differs: the hint of where a label is comes from voxels of the hull, which know who hides whom
// ADR:     0298, 0331

#include "pipeline/matte/label_follower.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

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
constexpr float kSaid = 100;      // nats against what somebody said
constexpr float kConfirms = 1, kDenies = 3;  // nats by which a pixel's label speaks for a voxel, or against
constexpr double kSmooth = 0.7;              // nats, two neighbours of different labels
constexpr int kBeginRounds = 4, kStepRounds = 2, kLooks = 3;
constexpr double kFade = 0.9;     // of colours, a frame
constexpr double kInertia = 0.5;  // of motion
constexpr int kNear = 3;          // edges between voxels of labels that are one body to the cameras
constexpr double kApart = 0.3;    // of a label near another: colours are learnt below that

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

// Where a label is expected in the instant after.
std::vector<Eigen::Vector3i> moved(const LabelInstant& from, std::size_t label) {
  std::vector<Eigen::Vector3i> places;
  const Eigen::Vector3i by = from.motion[label].array().round().cast<int>();
  for (const Eigen::Vector3i& p : from.places[label]) places.emplace_back(p + by);
  return places;
}

// An instant with voxels of another edge; none where it has them.
std::optional<LabelInstant> at_edge(const LabelInstant& instant, double edge) {
  if (instant.edge == edge) return std::nullopt;
  LabelInstant out = instant;
  out.places = with_edge(instant.places, instant.edge, edge);
  for (Eigen::Vector3d& m : out.motion) m *= instant.edge / edge;
  out.edge = edge;
  return out;
}

}  // namespace

LabelFollower::LabelFollower(capture::TakeReader& take, const LabelRecord& record, const LabelGivens& givens,
                             int threads)
    : take_(take),
      names_(record.labels),
      givens_(givens),
      threads_(threads),
      palette_(static_cast<int>(record.labels.size())),
      said_palette_(palette_),
      doubts_(take.rig(), record.labels, givens) {}

// Instants at which every label is said to be somewhere, from which the others are reached; else the one by
// which every label was.
std::vector<int> LabelFollower::starts() const {
  std::vector<int> frames;
  std::uint32_t so_far = 0;
  int last = 0;
  for (const auto& [frame, cameras] : givens_) {
    const std::uint32_t here = said_in(frame);
    if (here == everybody()) frames.push_back(frame);
    if (so_far != everybody()) so_far |= here, last = frame;
  }
  return frames.empty() ? std::vector<int>{last} : frames;
}

std::uint32_t LabelFollower::everybody() const {
  return static_cast<std::uint32_t>((std::uint64_t{1} << names_.size()) - 1);
}

// Labels that are said to be in a frame.
std::uint32_t LabelFollower::said_in(int frame) const {
  std::uint32_t said = 0;
  for (const auto& [camera, may] : givens_.at(frame))
    for (const std::uint32_t m : may) said |= std::popcount(m) == 1 ? m : 0;
  return said;
}

// An instant to start from. What was said before it, one label in one frame and one in another, comes with
// it.
Result<LabelInstant> LabelFollower::start(int frame) {
  Result<LabelInstant> here = begin(said_in(frame) == everybody() ? frame : givens_.begin()->first);
  while (here && here->frame < frame) here = step(*here, here->frame + 1);
  if (here) doubts_.loss(*here);
  return here;
}

Result<void> LabelFollower::run(const Done& done) {
  const int last = take_.frame_count() - 1;
  const std::vector<int> keys = starts();
  std::optional<LabelInstant> before;  // of the key frame before, walked on to the middle
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const int from = k == 0 ? 0 : (keys[k - 1] + keys[k]) / 2 + 1,
              to = k + 1 == keys.size() ? last : (keys[k] + keys[k + 1]) / 2;
    Result<LabelInstant> here = start(keys[k]);
    if (!here) return forward(here);
    if (Result<void> ok = done(*here); !ok) return ok;
    LabelInstant end = *here;
    if (Result<void> ok = walk(*here, from, done, end); !ok) return ok;
    if (before) {
      Result<LabelInstant> meets =
          end.frame == before->frame ? Result<LabelInstant>(end) : step(end, before->frame);
      if (!meets) return forward(meets);
      doubts_.meeting(*before, *meets);
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
    doubts_.loss(*next);
    doubts_.merged(*next, palette_);
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
  if (const std::map<int, LabelsAllowed>* said = said_of(frame))
    for (const auto& [camera, may] : *said)
      if (instant.mattes[static_cast<std::size_t>(camera)].empty())
        return fail(ErrorCode::NotFound,
                    text("camera '", take_.rig().cameras[static_cast<std::size_t>(camera)].serial,
                         "' has no matte of frame ", frame,
                         ", of which a label was given; run `floatstage matte` without labels first"));
  return instant;
}

const std::map<int, LabelsAllowed>* LabelFollower::said_of(int frame) const {
  return floatstage::pipeline::said_of(givens_, frame);
}

// `before`: cameras that were no witnesses.
LabelHull LabelFollower::hull_of(const LabelInstant& instant, const LabelPlaces& expected,
                                 const Disbelieved& before) {
  return label_hull(asked_of(instant, expected, before), voxel_);
}

LabelHullOf LabelFollower::asked_of(const LabelInstant& instant, const LabelPlaces& expected,
                                    const Disbelieved& before) const {
  return {.rig = take_.rig(),
          .mattes = instant.mattes,
          .frame = instant.frame,
          .said = said_of(instant.frame),
          .before = before,
          .expected = expected,
          .labels = static_cast<int>(names_.size()),
          .voxels = kVoxels,
          .threads = threads_};
}

// What words say that nobody can be meant by, and cameras that are no witnesses.
void LabelFollower::doubt(const LabelHull& hull, LabelInstant& instant) {
  instant.disbelieved = hull.disbelieved;
  doubts_.disbelieved(instant);
  for (const NowhereWord& word : hull.nowhere) doubts_.nowhere(word, instant.frame);
}

Result<LabelInstant> LabelFollower::begin(int frame) {
  Result<LabelInstant> opened = open(frame);
  if (!opened) return opened;
  const matting::LabelPalette palette = palette_;
  const double voxel = voxel_;
  Disbelieved before;
  for (int round = 0;; ++round) {
    LabelInstant instant = *opened;
    LabelHull hull = hull_of(instant, {}, before);
    if (!hull.volume)
      return fail(ErrorCode::BadData, text("frame ", frame, ": ", hull.why,
                                           "; labels need mattes of calibrated cameras that agree"));
    palette_ = palette;
    const Costs costs = begin_costs(*hull.volume, instant);
    const std::vector<std::uint8_t> voxels = settle(*hull.volume, costs, nullptr, kBeginRounds, instant);
    finish(*hull.volume, voxels, nullptr, instant);
    // Now that it is known where labels are: once more without cameras that have nobody there.
    Disbelieved lack = hull.disbelieved;
    if (round == 0 && said_in(frame) == everybody())
      lack.merge(who_lacks(asked_of(instant, {}, lack), *hull.volume, instant.places, lack));
    if (lack != hull.disbelieved) {
      before = std::move(lack);
      voxel_ = voxel;
      continue;
    }
    doubt(hull, instant);
    return instant;
  }
}

// Of each label, the way from what was said to be its.
std::vector<std::vector<float>> LabelFollower::ways_from(const recon::LabelVolume& volume,
                                                         const std::vector<std::vector<std::size_t>>& start) {
  std::vector<std::vector<float>> ways;
  for (const std::vector<std::size_t>& from : start) ways.push_back(volume.way_from(from));
  return ways;
}

// Of one voxel, by how much longer its way is than the shortest.
void LabelFollower::ask_ways(const std::vector<std::vector<float>>& ways, std::size_t voxel, float* of) {
  float least = recon::LabelVolume::kFar;
  for (const std::vector<float>& w : ways) least = std::min(least, w[voxel]);
  const bool reached = least < recon::LabelVolume::kFar;
  of[0] = reached ? kNobody : 0;
  for (std::size_t l = 0; l < ways.size(); ++l)
    of[l + 1] = reached ? std::min((ways[l][voxel] - least) / kStep, kMostAway) : kNobody;
}

// Voxels that somebody pointed at, and the ways from there.
Costs LabelFollower::begin_costs(const recon::LabelVolume& volume, const LabelInstant& instant) const {
  const auto ways = ways_from(volume, pointed_at(volume, givens_.at(instant.frame), instant.mattes));
  Costs costs = volume.no_costs();
  for (std::size_t v = 0; v < volume.size(); ++v) ask_ways(ways, v, costs.data() + v * (names_.size() + 1));
  return costs;
}

// Pieces that a word contradicts, by the colours that labels had when somebody last said who is who; where
// those do not tell, or one of the labels has none, by the ways from what was said.
void LabelFollower::correct(const recon::LabelVolume& volume, const LabelInstant& instant,
                            const LabelCorrection& correction, Costs& costs) {
  const std::size_t labels = names_.size();
  palette_ = said_palette_;
  const bool tell = colors_tell(correction, palette_, static_cast<int>(labels), kColorsAlike);
  Costs votes = volume.no_costs();
  if (tell) hear(volume, instant, correction.carried, votes);
  const auto ways = ways_from(volume, correction.seen);
  for (std::size_t v = 0; v < volume.size(); ++v) {
    if (!correction.anew[v]) continue;
    float* of = costs.data() + v * (labels + 1);
    if (!tell) {
      ask_ways(ways, v, of);
      continue;
    }
    of[0] = kNobody;
    for (std::size_t l = 0; l < labels; ++l)
      of[l + 1] = (correction.lost | correction.said) >> l & 1 ? votes[v * (labels + 1) + l + 1] : kMostAway;
  }
  for (std::size_t l = 0; l < labels; ++l)
    for (const std::size_t v : correction.seen[l])
      for (std::size_t other = 0; other <= labels; ++other)
        if (other != l + 1) costs[v * (labels + 1) + other] += kSaid;
}

Costs LabelFollower::carried_costs(const recon::LabelVolume& volume, const LabelInstant& from) const {
  const std::size_t labels = names_.size();
  Costs costs = volume.no_costs();
  for (std::size_t v = 0; v < volume.size(); ++v) costs[v * (labels + 1)] = kNobody;
  for (std::size_t l = 0; l < labels; ++l) {
    const std::vector<float> away = volume.distance_to(moved(from, l));
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
  const std::map<int, LabelsAllowed>* said = said_of(instant.frame);
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
    const bool given = said && said->contains(camera);
    const bool known = near && !near->labels[c].empty();
    instant.labels[c] = matting::split_labels({.picture = instant.pictures[c],
                                               .matte = instant.mattes[c],
                                               .hint = hint,
                                               .where = where,
                                               .slack = std::max(3.0, 1.0 * volume.cell(camera)),
                                               .labels = static_cast<int>(names_.size()),
                                               .may = given ? said->at(camera) : anything_,
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
    const matting::LabelPalette before =
        std::exchange(palette_, matting::LabelPalette(static_cast<int>(names_.size())));
    for (std::size_t c = 0; c < instant.labels.size(); ++c)
      if (!instant.sure[c].empty()) palette_.learn(instant.pictures[c], instant.mattes[c], instant.sure[c]);
    palette_.take_unknown(before);
  }
  if (!near) said_palette_ = palette_;
  return voxels;
}

// Voxels' edge is chosen anew where it was chosen from a part of the stage.
Result<LabelInstant> LabelFollower::step(const LabelInstant& neighbour, int frame) {
  Result<LabelInstant> instant = open(frame);
  if (!instant) return instant;
  std::optional<LabelInstant> other = at_edge(neighbour, voxel_);
  const LabelInstant& at = other ? *other : neighbour;
  LabelPlaces expected;
  for (std::size_t l = 0; l < at.places.size(); ++l) expected.push_back(moved(at, l));
  const LabelHull hull = hull_of(*instant, expected, at.disbelieved);
  std::optional<LabelInstant> another = at_edge(at, voxel_);
  const LabelInstant& from = another ? *another : at;
  doubt(hull, *instant);
  if (!hull.volume) {
    split_alone(from, *instant);
    return instant;
  }
  const std::optional<recon::LabelVolume>& volume = hull.volume;
  Costs costs = carried_costs(*volume, from);
  LabelCorrection correction;
  if (const std::map<int, LabelsAllowed>* said = said_of(frame))
    correction = find_correction(*volume, *said, instant->mattes, volume->label(costs, kSmooth));
  if (correction.none()) {
    const std::vector<std::uint8_t> voxels = settle(*volume, costs, &from, kStepRounds, *instant);
    finish(*volume, voxels, &from, *instant);
    return instant;
  }
  correct(*volume, *instant, correction, costs);
  const std::vector<std::uint8_t> voxels = settle(*volume, costs, nullptr, kBeginRounds, *instant);
  finish(*volume, voxels, nullptr, *instant);
  doubts_.unheard(correction, voxels, *instant);
  doubts_.taken(correction, voxels, *instant);
  for (std::size_t l = 0; l < names_.size(); ++l)  // of whom nothing is seen, not whom it was taken from
    if (instant->places[l].empty() && !(correction.lost >> l & 1))
      instant->places[l] = from.places[l], instant->motion[l] = from.motion[l];
  return instant;
}

// Where space says nothing, each picture alone, from the one beside it.
void LabelFollower::split_alone(const LabelInstant& from, LabelInstant& instant) const {
  instant.edge = from.edge;
  instant.places = from.places;
  instant.motion = from.motion;
  const std::map<int, LabelsAllowed>* said = said_of(instant.frame);
  for (std::size_t c = 0; c < instant.mattes.size(); ++c) {
    if (instant.mattes[c].empty()) continue;
    const bool given = said && said->contains(static_cast<int>(c));
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
                                               .may = given ? said->at(static_cast<int>(c)) : anything_,
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
  instant.edge = voxel_;
  instant.places.resize(names_.size());
  instant.motion.assign(names_.size(), Eigen::Vector3d::Zero());
  for (std::size_t v = 0; v < voxels.size(); ++v)
    if (voxels[v] > 0) instant.places[voxels[v] - 1U].push_back(volume.places()[v]);
  for (const std::vector<Eigen::Vector3i>& places : instant.places) instant.voxels.push_back(places.size());
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

}  // namespace floatstage::pipeline
