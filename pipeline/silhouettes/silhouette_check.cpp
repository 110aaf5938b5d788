// Method:  each camera's silhouettes against the hull of all others; the camera whose turn takes most away
// Paper:   C. Hernández, F. Schmitt, R. Cipolla, "Silhouette coherence for camera calibration under circular
//          motion", 2007
// Differs: the cameras are asked one by one, and one that explains the disagreement of all is named
// ADR:     0233

#include "pipeline/silhouettes/silhouette_check.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <span>
#include <sstream>

#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/silhouettes/left_out_hulls.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {
namespace {

using calib::SilhouetteTurn;

constexpr std::size_t kFewestCameras = 4;  // without one of them, three still bound a body
constexpr double kSigmas = 5;              // a turn that is none is that far off once in a million
constexpr double kStandsOut = 3;           // times what cameras usually disagree by
constexpr double kExplained = 0.5;         // of what all cameras want to turn may be left
constexpr std::size_t kSuspects = 2;       // the guilty camera, and the one that looks from the far side
constexpr int kSettling = 2;               // rounds over the named cameras

void turn(Rig& rig, std::size_t camera, const Eigen::Vector3d& vector) {
  Rigid3& pose = rig.cameras[camera].cam_from_world;
  pose = calib::turned(pose, vector);
}

/// A rig, and by how much its cameras would have to turn.
struct State {
  Rig rig;
  std::vector<SilhouetteTurn> turns;
  std::vector<bool> named;
};

class Search {
 public:
  Search(const LeftOutHulls& hulls, const SilhouetteCheckOptions& options)
      : hulls_(hulls), options_(options) {}

  std::vector<SilhouetteTurn> turns_of(const Rig& rig) const {
    std::vector<SilhouetteTurn> turns = hulls_.turns_of(rig);
    for (std::size_t c = 0; c < turns.size(); ++c) subtract_reference(turns[c], c);
    return turns;
  }

  /// Names one camera more, if one explains what most cameras feel. False when none does though some
  /// disagree.
  bool name_one(State& state) const {
    std::vector<std::size_t> suspects = suspects_of(state);
    if (suspects.empty()) return true;
    std::optional<State> best;
    std::size_t guilty = 0;
    const std::optional<double> iou = hulls_.iou_of(state.rig);
    for (const std::size_t c : suspects) {
      State trial = state;
      trial.named[c] = true;
      turn(trial.rig, c, state.turns[c].vector);
      settle(trial);
      // A turned camera cuts the hull: turned back, it lets all silhouettes be explained better.
      if (hulls_.iou_of(trial.rig) <= iou) continue;
      trial.turns = turns_of(trial.rig);
      if (!best || unrest(trial) < unrest(*best)) best = std::move(trial), guilty = c;
    }
    if (!best) return false;
    if (state.turns[guilty].degrees < kStandsOut * usual_turn(*best) ||
        unrest(*best) > kExplained * unrest(state))
      return false;
    state = std::move(*best);
    return true;
  }

  double usual_turn(const State& state) const {
    std::vector<double> others;
    for (std::size_t c = 0; c < state.turns.size(); ++c)
      if (state.turns[c].known && !state.named[c]) others.push_back(state.turns[c].degrees);
    return others.empty() ? 0 : median(std::move(others));
  }

 private:
  void subtract_reference(SilhouetteTurn& t, std::size_t camera) const {
    if (!t.known || options_.reference.empty()) return;
    t.vector -= options_.reference[camera];
    t.degrees = t.vector.norm() * 180 / std::numbers::pi;
  }

  /// The cameras that would gain most by a turn of their own. A camera on the far side gains nearly as much
  /// as the guilty one, whose outline it shares.
  std::vector<std::size_t> suspects_of(const State& state) const {
    std::vector<std::size_t> found;
    for (std::size_t c = 0; c < state.turns.size(); ++c) {
      const SilhouetteTurn& t = state.turns[c];
      // What outlines contribute is most of sigma, and a reference has it too.
      const bool sure = !options_.reference.empty() || t.degrees > kSigmas * t.sigma_degrees;
      if (!state.named[c] && t.known && sure && t.degrees > options_.alarm_degrees) found.push_back(c);
    }
    std::stable_sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) {
      return state.turns[a].degrees > state.turns[b].degrees;
    });
    found.resize(std::min(found.size(), kSuspects));
    return found;
  }

  /// How much all cameras together want to turn, degrees².
  static double unrest(const State& state) {
    double sum = 0;
    for (const SilhouetteTurn& t : state.turns) sum += t.known ? t.degrees * t.degrees : 0;
    return sum;
  }

  // A camera that has turned is nearer to its silhouettes, which are then told from outliers better.
  void settle(State& state) const {
    for (int round = 0; round < kSettling; ++round)
      for (std::size_t c = 0; c < state.named.size(); ++c) {
        if (!state.named[c]) continue;
        SilhouetteTurn t = hulls_.turn_of(state.rig, c);
        subtract_reference(t, c);
        if (t.known) turn(state.rig, c, t.vector);
      }
  }

  const LeftOutHulls& hulls_;
  const SilhouetteCheckOptions& options_;
};

// Names cameras one after the other until all agree, or nobody can be named.
struct Found {
  State state;
  std::vector<SilhouetteTurn> before;
  bool whole_rig = false;
  double usual_degrees = 0;
};

Found find(const Rig& rig, const std::vector<InstantMattes>& instants,
           const SilhouetteCheckOptions& options) {
  const LeftOutHulls asked(rig, instants, options.quick, options.threads, options.progress);
  const Search search(asked, options);
  const State given{rig, search.turns_of(rig), std::vector<bool>(rig.cameras.size(), false)};
  Found found{given, given.turns, false, 0};
  const auto count = [](const State& state) {
    return std::count(state.named.begin(), state.named.end(), true);
  };
  const auto most = static_cast<std::ptrdiff_t>(rig.cameras.size() / 4);
  while (!found.whole_rig && !is_cancelled(options.progress)) {
    State next = found.state;
    found.whole_rig = !search.name_one(next) || count(next) > most;
    if (count(next) > most) found.state = given;
    if (found.whole_rig || count(next) == count(found.state)) break;
    found.state = std::move(next);
  }
  found.usual_degrees = search.usual_turn(found.state);
  return found;
}

// By camera, in how many instants the audit accuses its matte; those mattes are taken out.
std::vector<int> take_out_wrong(const Rig& rig, std::vector<InstantMattes>& instants) {
  std::vector<int> wrong(rig.cameras.size(), 0);
  recon::HullOptions options = silhouette_hull_options(false);
  options.voting = recon::HullVoting::Auto;
  for (InstantMattes& mattes : instants) {
    const auto hull = recon::visual_hull(rig, mattes, options);
    if (!hull) continue;
    for (const recon::SilhouetteVerdict& verdict : hull->verdicts) {
      ++wrong[static_cast<std::size_t>(verdict.camera)];
      mattes[static_cast<std::size_t>(verdict.camera)] = Matte{};
    }
  }
  return wrong;
}

Result<void> check(const Rig& rig, const std::vector<InstantMattes>& instants,
                   const SilhouetteCheckOptions& options) {
  if (rig.cameras.size() < kFewestCameras)
    return fail(ErrorCode::InvalidArgument, text("silhouettes tell poses of ", kFewestCameras,
                                                 " cameras and more, not of ", rig.cameras.size()));
  for (const InstantMattes& mattes : instants)
    if (mattes.size() != rig.cameras.size())
      return fail(ErrorCode::InvalidArgument,
                  text(mattes.size(), " mattes for ", rig.cameras.size(), " cameras"));
  if (!options.reference.empty() && options.reference.size() != rig.cameras.size())
    return fail(ErrorCode::InvalidArgument,
                text("a reference of ", options.reference.size(), " cameras for ", rig.cameras.size()));
  return {};
}

std::string fixed(double value, int digits) {
  std::ostringstream s;
  s << std::fixed << std::setprecision(digits) << value;
  return s.str();
}

}  // namespace

Result<SilhouetteCheck> check_silhouettes(const Rig& given, const std::vector<InstantMattes>& instants,
                                          const SilhouetteCheckOptions& options) {
  if (Result<void> ok = check(given, instants, options); !ok) return forward(ok);
  std::vector<MisplacedCamera> misplaced;
  if (!options.quick) misplaced = misplaced_cameras(given, instants, options.threads);
  const std::optional<Rig> in_place = with_cameras_in_place(given, misplaced);
  const Rig& rig = in_place ? *in_place : given;
  std::vector<InstantMattes> good = instants;
  if (!in_place)
    for (InstantMattes& mattes : good)
      for (const MisplacedCamera& one : misplaced) mattes[one.camera] = Matte{};
  Found found = find(rig, good, options);
  const std::vector<bool>& named = found.state.named;
  std::vector<int> wrong(rig.cameras.size(), 0);
  if (!options.quick || std::find(named.begin(), named.end(), true) != named.end())
    wrong = take_out_wrong(found.state.rig, good);
  if (std::any_of(wrong.begin(), wrong.end(), [](int n) { return n > 0; })) found = find(rig, good, options);
  if (is_cancelled(options.progress)) return cancelled_unwritten();
  const auto known =
      std::count_if(found.before.begin(), found.before.end(), [](const auto& t) { return t.known; });
  if (known < static_cast<std::ptrdiff_t>(kFewestCameras))
    return fail(ErrorCode::NotFound,
                text("not measured: only ", known, " cameras show a subject that the others bound; ",
                     kFewestCameras, " are needed"));
  SilhouetteCheck out;
  out.misplaced = std::move(misplaced);
  out.corrected = found.state.rig;
  out.whole_rig = found.whole_rig;
  out.usual_degrees = found.usual_degrees;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    SilhouetteCameraCheck one{
        rig.cameras[c].serial, found.before[c], found.state.turns[c], found.state.named[c], 0, wrong[c]};
    const double turn = rig.cameras[c].cam_from_world.rotation.angularDistance(
        out.corrected.cameras[c].cam_from_world.rotation);
    one.turned_degrees = turn * 180 / std::numbers::pi;
    out.cameras.push_back(std::move(one));
  }
  if (std::any_of(out.cameras.begin(), out.cameras.end(), [](const auto& c) { return c.named; })) {
    const LeftOutHulls asked(rig, good, options.quick, options.threads, options.progress);
    out.iou_before = asked.iou_of(rig), out.iou_after = asked.iou_of(out.corrected);
  }
  return out;
}

std::string sentence(const SilhouetteCameraCheck& c) {
  return text("camera '", c.serial, "' stands otherwise than its calibration says: a turn by ",
              fixed(c.turned_degrees, 2), " +- ", fixed(c.before.sigma_degrees, 2),
              " degrees makes its silhouettes agree with the others' (", fixed(c.before.outside_px, 2),
              " px outside of what they leave before, ", fixed(c.after.outside_px, 2), " px after)");
}

std::vector<std::string> sentences(const SilhouetteCheck& check) {
  std::vector<std::string> out;
  for (const MisplacedCamera& c : check.misplaced) out.push_back(sentence(check.corrected, c));
  for (const SilhouetteCameraCheck& c : check.cameras)
    if (c.named) out.push_back(sentence(c));
  for (const SilhouetteCameraCheck& c : check.cameras)
    if (c.wrong_mattes > 0)
      out.push_back(text("camera '", c.serial, "': the others contradict its matte in ", c.wrong_mattes,
                         c.wrong_mattes == 1 ? " instant" : " instants",
                         ", however it is turned; the matte is wrong, not the pose"));
  if (check.whole_rig)
    out.push_back(text("poses and silhouettes disagree (the cameras usually want to turn by ",
                       fixed(check.usual_degrees, 2),
                       " degrees), and no turn of one camera explains it: look at the mattes' outlines, then "
                       "calibrate the whole rig again"));
  return out;
}

}  // namespace floatstage::pipeline
