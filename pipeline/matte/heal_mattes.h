#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/matte.h"
#include "core/result.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/mesh_record.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// A camera whose mattes the others contradicted, and that were cut anew by the others' evidence.
struct HealedCamera {
  std::string serial;
  int frames = 0;           ///< in so many
  int worst = 0;            ///< frame
  double lost = 0;          ///< there, before, see recon::SilhouetteVerdict; 1: it had no matte
  double gained = 0;        ///< likewise
  std::vector<int> filled;  ///< frames that had no matte
};

/// "camera 'x': 7 mattes were cut anew by what the others see; that of frame 3 lacked 62 % of it"
std::string sentence(const HealedCamera& healed);

/// Whether what a person says makes the matte of a frame another one, so that it is kept as it is: masks that
/// hold there, strokes of its own that act, and what is carried from those of other frames. Of mattes that
/// are cut out from a stroke, chosen by strokes (spectral) or made of all cameras at once: where strokes
/// concern it at all.
bool is_persons(const CameraRecord& record, int frame);

/// Cuts mattes anew that the others contradict, or that the camera's key refused to make: from the hull and
/// the colours of the cameras that nobody accuses (rekey()). Who is accused the audit says; where it sees
/// nothing, and yet more than a tenth of half of the silhouettes stays unexplained, those are that lack most
/// of what the others see, pixel by pixel (docs/adr/0194-a-wrong-matte-is-cut-anew-by-the-others.md).
///
/// Where that leaves more than a twentieth of half of the silhouettes open, and eight cameras have mattes,
/// keys by colour are weighed against the colours and against what all cameras see
/// (ConsistentMatting::reconcile()): there many lack or add a little, each somewhere else
/// (docs/adr/0328-keys-are-weighed-by-all-cameras.md).
///
/// Only mattes that we made; what somebody put there is never touched, nor those that a person's edits made
/// others (is_persons()). What strokes of the frame mark, though they changed nothing, stays as it is. A new
/// matte is believed, and written, only when the audit then finds less wrong with its camera and nothing
/// worse with any other; else the old one stays, is outvoted as before, and named. The record keeps which
/// instants were looked at (CameraRecord::compared): the same mattes are looked at once, whoever asks. Thread
/// safe, by frames.
class MatteHealer {
 public:
  /// `take` outlives it. Errors: those of MatteStore::open().
  static Result<std::unique_ptr<MatteHealer>> open(capture::TakeReader& take);

  /// Asked before any matte is looked at closer: whether what cameras show is evidence for one another. From
  /// any thread.
  void ask_first(std::function<Result<bool>()> may_heal) { may_heal_ = std::move(may_heal); }

  /// Whether all mattes of the instant that we made were compared with those that lie there now, of these
  /// hashes.
  bool compared(int frame, const MatteHashes& hashes);
  /// `mattes`, `hashes`: of the instant; healed ones are replaced. `hull`: what they gave, made by Auto votes
  /// with `options`. Whether any was healed; none is where they were compared before. Errors: Io, those of
  /// the photographs.
  Result<bool> heal(int frame, const recon::HullReport& hull, const recon::HullOptions& options,
                    std::vector<Matte>& mattes, MatteHashes& hashes);

  /// Writes the record. Worst first.
  Result<std::vector<HealedCamera>> finish();

 private:
  struct Patient {
    std::size_t camera = 0;
    Healing before;
  };
  MatteHealer(capture::TakeReader& take, std::unique_ptr<MatteStore> store)
      : take_(take), store_(std::move(store)) {}
  Result<bool> look(int frame, const recon::HullReport& hull, const recon::HullOptions& options,
                    std::vector<Matte>& mattes);
  Result<std::vector<Patient>> patients(int frame, const recon::HullReport& hull,
                                        const std::vector<Matte>& mattes, int threads);
  Result<std::vector<Matte>> cut_anew(int frame, const std::vector<Patient>& patients,
                                      const recon::HullOptions& options, const std::vector<Matte>& mattes);
  void spare(std::vector<Patient>& patients, const recon::HullOptions& options,
             const std::vector<std::size_t>& witnesses, const std::vector<Matte>& mattes,
             std::vector<Matte>& anew, recon::HullReport& after);
  Result<bool> keep(int frame, const std::vector<Patient>& patients,
                    const std::vector<std::size_t>& witnesses, const std::vector<double>& now,
                    const std::vector<double>& before, std::vector<Matte>& anew, std::vector<Matte>& mattes);
  Result<bool> treat(int frame, const recon::HullReport& hull, const recon::HullOptions& quick,
                     std::vector<Matte>& mattes);
  Result<bool> weigh(int frame, const recon::HullReport& hull, const recon::HullOptions& quick,
                     const std::vector<bool>& by_key, std::vector<Matte>& mattes);
  Result<bool> replace(std::size_t camera, int frame, Healing healing, Matte anew, Matte& matte);
  Result<bool> may_heal() { return may_heal_ ? may_heal_() : Result<bool>(true); }
  Result<bool> ours(const std::string& serial, int frame, bool there);
  bool by_colour(const std::string& serial, int frame);
  void hold(std::size_t camera, int frame, const Matte& matte, Matte& anew);

  capture::TakeReader& take_;
  std::unique_ptr<MatteStore> store_;
  std::function<Result<bool>()> may_heal_;  // none: they are
  std::mutex mutex_;
  std::map<std::string, HealedCamera> healed_;
  std::set<std::string> touched_;  // cameras of whose record something is new
};

}  // namespace floatstage::pipeline
