#include "pipeline/matte/edited_camera.h"

#include <algorithm>
#include <mutex>

#include <unistd.h>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/matte/affected_frames.h"
#include "pipeline/matte/consistent_take.h"
#include "pipeline/matte/matte_doubts.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/matte/matte_job.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

Unexpected stopped() { return fail(ErrorCode::Cancelled, "stopped; what was finished is kept"); }

// Whether a picture was recorded there, as far as the side file knows.
bool recorded(const capture::TakeReader& take, int camera, int frame) {
  const std::vector<FrameRow>& rows = take.rows(camera);
  return static_cast<std::size_t>(frame) < rows.size() && rows[static_cast<std::size_t>(frame)].media_index;
}

// For jobs that are watched otherwise.
class WatchProgress final : public Progress {
 public:
  explicit WatchProgress(const RemakeWatch& watch) : watch_(watch) {}
  void begin(const std::string& what, std::size_t total) override {
    const std::lock_guard lock(mutex_);
    what_ = what, all_ = static_cast<int>(total), done_ = 0;
    watch_.progress(what_, done_, all_);
  }
  void advance(std::size_t items) override {
    const std::lock_guard lock(mutex_);
    watch_.progress(what_, done_ += static_cast<int>(items), all_);
  }
  void end() override {}
  bool cancelled() const override { return watch_.stopped(); }

 private:
  const RemakeWatch& watch_;
  std::mutex mutex_;
  std::string what_;
  int all_ = 0, done_ = 0;
};

// Removed when it goes out of scope: components that are only to be looked at are not kept in the take.
struct ScratchFolder {
  fs::path path;
  ~ScratchFolder() {
    std::error_code none;
    fs::remove_all(path, none);
  }
};

}  // namespace

EditedCamera::EditedCamera(std::unique_ptr<capture::TakeReader> take, std::unique_ptr<MatteStore> store,
                           int camera, EditedCameraOptions options)
    : take_(std::move(take)), store_(std::move(store)), camera_(camera), options_(std::move(options)) {}

Result<std::unique_ptr<EditedCamera>> EditedCamera::open(const EditedCameraOptions& options) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.take);
  if (!take) return forward(take);
  const int camera = camera_index((*take)->rig(), options.serial);
  if (camera < 0)
    return fail(ErrorCode::InvalidArgument,
                text(options.take.string(), " has no camera '", options.serial, "'"));
  if (!options.how.empty())
    if (Result<void> ok = check_matte_how(options.how); !ok) return forward(ok);
  Result<std::unique_ptr<MatteStore>> store = MatteStore::open((*take)->layout());
  if (!store) return forward(store);
  Result<MatteEdits> edits = load_matte_edits((*take)->layout().edits());
  if (!edits) return forward(edits);
  std::unique_ptr<EditedCamera> edited(
      new EditedCamera(std::move(*take), std::move(*store), camera, options));
  edited->on_disk_ = edits->cameras[options.serial];
  if (Result<void> ok = edited->settle(); !ok) return forward(ok);
  return edited;
}

// Which way the mattes go, and for which edits those that are there were made.
Result<void> EditedCamera::settle() {
  const CameraRecord* before = store_->find(options_.serial);
  how_ = !options_.how.empty() ? options_.how : before ? before->how : "";
  if (how_.empty()) {
    Result<std::string> usual = usual_way(*take_, *store_);
    if (!usual) return forward(usual);
    how_ = std::move(*usual);
  }
  const std::string guide =
      !options_.how.empty()
          ? options_.guide.empty() ? "" : fs::absolute(options_.guide).lexically_normal().string()
      : before ? before->guide
               : "";
  Result<std::string> inputs = hash_of_inputs(*take_, options_.serial, guide);
  if (!inputs) return forward(inputs);
  const bool same = before && before->how == how_ && before->guide == guide && before->inputs == *inputs;
  if (same) {
    made_for_ = before->edits;
    return {};
  }
  // What somebody put into the take is what nobody has edited yet.
  if (!before && how_ == "given") made_for_ = CameraEdits();
  CameraRecord& mine = record();
  mine.how = how_, mine.guide = guide, mine.inputs = std::move(*inputs);
  mine.method.clear(), mine.key.clear();
  return {};
}

std::vector<bool> EditedCamera::changed_since(const CameraEdits& edits) const {
  const int count = take_->frame_count();
  if (!made_for_) return std::vector<bool>(static_cast<std::size_t>(count), true);
  const CameraRecord& mine = record();
  std::vector<bool> out = frames_made_otherwise(mine.method, mine.key, *made_for_, edits, count);
  for (int f = 0; f < count; ++f)
    if (mine.stale.contains(f) || (how_ != "given" && recorded(*take_, camera_, f) && !is_there(file(f))))
      out[static_cast<std::size_t>(f)] = true;
  return out;
}

std::vector<bool> EditedCamera::stale(const CameraEdits& edits) const {
  const std::string& method = record().method;
  std::vector<bool> changed = changed_since(edits);
  return method == "spectral" || method == "consistent" ? changed : downstream_of(std::move(changed), edits);
}

std::map<int, std::vector<std::string>> EditedCamera::doubts() const {
  std::map<int, std::vector<std::string>> by_frame;
  const CameraRecord* mine = store_->find(options_.serial);
  for (const auto& [why, frames] : mine ? mine->doubts : decltype(mine->doubts)())
    for (const int frame : frames)
      if (frame >= 0 && frame < take_->frame_count()) by_frame[frame].push_back(why);
  return by_frame;
}

std::vector<bool> EditedCamera::guided() const {
  std::vector<bool> frames(static_cast<std::size_t>(take_->frame_count()));
  const CameraRecord* mine = store_->find(options_.serial);
  for (const int frame : mine ? mine->guided : std::set<int>())
    if (frame >= 0 && frame < take_->frame_count()) frames[static_cast<std::size_t>(frame)] = true;
  return frames;
}

Result<void> EditedCamera::make_key(const CameraEdits& edits, const RemakeWatch& watch) {
  CameraRecord& mine = record();
  if (how_ == "consistent" || mine.method == "consistent") {
    mine.method = mine.key = "consistent";
    return {};
  }
  if (key_ && key_->uses_strokes() && seed_of(key_edits_) != seed_of(edits))
    key_.reset(), spectral_.reset(), prepared_ = false;
  if (!key_) {
    watch.progress("key", 0, 1);
    Result<CameraKey> key =
        CameraKey::for_how(*take_, camera_, how_, mine.guide, edits, [&] { return !watch.stopped(); });
    if (!key) return forward(key);
    if (Result<void> ok = key->ready(); !ok) return ok;
    key_.emplace(std::move(*key));
    key_edits_ = edits;
    const bool other =
        key_->kind() == CameraKey::Kind::Cut && made_for_ && seed_of(*made_for_) != seed_of(edits);
    if (other) made_for_.reset(), mine.method.clear();
    if (mine.key != key_->spec())
      made_for_.reset(), mine.method.clear();  // a plate was shot since, or there were no mattes
    mine.key = key_->spec();
  }
  if (!mine.method.empty()) return {};
  Result<std::string> chosen = CameraMatting(*take_, camera_, *key_, {}, how_).chosen_method();
  if (!chosen) return forward(chosen);
  mine.method = std::move(*chosen);
  return {};
}

// What somebody put there becomes ours to change: the originals are kept, and say from now on what is
// subject.
Result<bool> EditedCamera::adopt(const std::vector<bool>& wanted) {
  const Result<std::vector<MatteOrigin>> origins = store_->origins(options_.serial, take_->frame_count());
  if (!origins) return forward(origins);
  int concerned = 0;
  for (std::size_t f = 0; f < wanted.size(); ++f)
    concerned += wanted[f] && (*origins)[f] == MatteOrigin::Others;
  if (concerned == 0) return false;
  if (!options_.replace)
    return fail(ErrorCode::AlreadyExists,
                text(concerned, " mattes of camera '", options_.serial,
                     "' that this edit concerns were not made by Floatstage, so they are not changed"));
  const fs::path given = take_->layout().given_mattes(options_.serial);
  if (Result<void> ok = make_folder(given); !ok) return forward(ok);
  CameraRecord& mine = record();
  for (std::size_t f = 0; f < origins->size(); ++f) {
    if ((*origins)[f] != MatteOrigin::Others) continue;
    const int frame = static_cast<int>(f);
    const Result<std::string> bytes = read_file(file(frame));
    if (!bytes) return forward(bytes);
    if (Result<void> ok = write_file(given / file(frame).filename(), *bytes); !ok) return forward(ok);
    mine.files[frame] = capture::sha256(*bytes);
  }
  Result<std::string> inputs = hash_of_inputs(*take_, options_.serial, mine.guide);
  if (!inputs) return forward(inputs);
  mine.inputs = std::move(*inputs);
  if (how_ == "given" && mine.key.empty()) mine.key = "guide", mine.method = "key";
  key_.reset(), spectral_.reset(), prepared_ = false;
  return true;
}

// From here on the record speaks of these edits, and of the mattes that are not theirs yet.
Result<void> EditedCamera::begin(const CameraEdits& edits, const std::vector<bool>& stale) {
  const fs::path folder = take_->layout().mattes() / options_.serial;
  if (Result<void> ok = make_folder(folder); !ok) return ok;
  sweep_temporaries(folder);
  CameraRecord& mine = record();
  mine.edits = without_subjects(edits);
  mine.stale.clear();
  for (std::size_t f = 0; f < stale.size(); ++f)
    if (stale[f] && is_there(file(static_cast<int>(f)))) mine.stale.insert(static_cast<int>(f));
  if (Result<void> ok = store_->save({options_.serial}); !ok) return ok;
  made_for_ = edits;
  return {};
}

Result<std::vector<int>> EditedCamera::remake(const CameraEdits& edits, const RemakeWatch& watch) {
  failures_.clear();
  idle_.clear();
  ended_.clear();
  if (const std::vector<bool> wanted = stale(edits);
      std::find(wanted.begin(), wanted.end(), true) == wanted.end() &&
      record().edits == without_subjects(edits))
    return std::vector<int>();
  WatchProgress waiting(watch);
  const Result<Claim> claim = claim_take(take_->layout().folder(), &waiting);
  if (!claim) return forward(claim);
  Result<bool> adopted = adopt(stale(edits));
  do {  // another key may concern more, and what was adopted is another key
    if (!adopted) return forward(adopted);
    if (Result<void> ok = make_key(edits, watch); !ok) return forward(ok);
    if (watch.stopped()) return stopped();
    adopted = adopt(stale(edits));
  } while (!adopted || *adopted);
  const std::vector<bool> forced = changed_since(edits), wanted = stale(edits);
  strokes_only_ = made_for_ && made_for_->masks == edits.masks && record().stale.empty();
  if (Result<void> ok = begin(edits, wanted); !ok) return forward(ok);
  Result<std::vector<int>> changed = make(edits, forced, wanted, watch);
  if (changed) record().stale.clear();
  if (Result<void> ok = store_->save({options_.serial}); !ok)
    return changed ? Result<std::vector<int>>(forward(ok)) : changed;
  return changed;
}

Result<std::vector<int>> EditedCamera::make(const CameraEdits& edits, const std::vector<bool>& forced,
                                            const std::vector<bool>& wanted, const RemakeWatch& watch) {
  const std::string method = record().method;
  if (method == "consistent") return consistent(edits, wanted, watch);
  const CameraMatting matting(*take_, camera_, *key_, edits, method);
  return method == "spectral" ? spectral(matting, wanted, watch) : follow(matting, forced, watch);
}

// Puts a matte into its place. Whether another one lies there now.
Result<bool> EditedCamera::put(int frame, Result<Image> matte) {
  if (!matte && matte.error().code == ErrorCode::Io) return forward(matte);
  if (!matte)
    failures_.push_back(text("camera '", options_.serial, "', frame ", frame, ": ", matte.error().message));
  if (matte && !matte->empty()) return store_->put(options_.serial, frame, *matte);
  const bool there = is_there(file(frame));
  if (Result<void> ok = store_->remove(options_.serial, frame); !ok) return forward(ok);
  return there;
}

// All cameras are looked at; of this one the mattes are written.
Result<std::vector<int>> EditedCamera::consistent(const CameraEdits& edits, const std::vector<bool>& stale,
                                                  const RemakeWatch& watch) {
  Result<MatteEdits> all = load_matte_edits(take_->layout().edits());
  if (!all) return forward(all);
  all->cameras[options_.serial] = edits;
  const std::map<int, std::string> before = record().files;
  WatchProgress progress(watch);
  const Result<ConsistentTakeReport> made = consistent_take(
      *take_, *all,
      {.matting = {.threads = options_.threads}, .cameras = {{camera_, stale}}, .progress = &progress},
      *store_);
  if (!made) return forward(made);
  std::vector<int> changed;
  for (const auto& [frame, hash] : record().files)
    if (const auto old = before.find(frame); old == before.end() || old->second != hash)
      changed.push_back(frame), watch.made(frame);
  return changed;
}

Result<std::vector<int>> EditedCamera::follow(const CameraMatting& matting, std::vector<bool> forced,
                                              const RemakeWatch& watch) {
  std::vector<int> changed;
  std::optional<Error> failure;
  std::mutex mutex;  // of everything below
  const std::vector<bool> wanted = downstream_of(forced, matting.edits());
  const int all = static_cast<int>(std::count(wanted.begin(), wanted.end(), true));
  int done = 0;
  const auto go_on = [&] { return !failure && !watch.stopped(); };
  const auto make = [&](int frame, const CameraMatting::Link& previous) -> CameraMatting::Link {
    Result<CameraMatting::Link> made = matting.matte(frame, previous);
    CameraMatting::Link link = made ? std::move(*made) : CameraMatting::Link{frame, {}};
    std::lock_guard lock(mutex);
    idle_.insert(idle_.end(), link.idle.begin(), link.idle.end());
    if (made && strokes_only_ && heals_on(*store_, options_.serial, matting.edits(), link)) {
      record().stale.erase(frame);
      watch.progress("mattes", ++done, all);
      return link;
    }
    const Result<bool> other = put(frame, made ? Result<Image>(link.matte) : forward(made));
    if (other && made) note_guidance(link, record());
    for (const std::string& ended : link.ended) ended_.push_back(text("frame ", frame, ": ", ended));
    if (!other) failure = failure ? failure : other.error();
    link.changed = other && *other;
    if (link.changed) changed.push_back(frame), watch.made(frame);
    watch.progress("mattes", ++done, all);
    return link;
  };
  if (!matting.follows()) {
    std::vector<int> frames;
    for (std::size_t f = 0; f < forced.size(); ++f)
      if (forced[f]) frames.push_back(static_cast<int>(f));
    parallel_for(frames.size(), options_.threads, [&](std::size_t i) {
      const auto may = [&] {
        std::lock_guard lock(mutex);
        return go_on();
      };
      if (may()) make(frames[i], {});
    });
  } else {
    const auto any_wanted_beyond = [&](int frame) {  // somebody may ask for this frame's matte
      const auto at = [&](int f) {
        return f >= 0 && static_cast<std::size_t>(f) < wanted.size() &&
               (wanted[static_cast<std::size_t>(f)] || !is_there(file(f)));
      };
      return at(frame - 1) || at(frame + 1);
    };
    matting.follow(go_on, [&](int frame, const CameraMatting::Link& previous) -> CameraMatting::Link {
      if (forced[static_cast<std::size_t>(frame)] || previous.changed) return make(frame, previous);
      record().stale.erase(frame);
      if (wanted[static_cast<std::size_t>(frame)]) watch.progress("mattes", ++done, all);
      if (!any_wanted_beyond(frame) || !is_there(file(frame))) return {};
      Result<Image> matte = load_png(file(frame));
      return matte ? link_of(&record(), frame, std::move(*matte)) : CameraMatting::Link{frame, {}};
    });
  }
  if (failure) return Unexpected{*failure};
  if (watch.stopped() && !record().stale.empty()) return stopped();
  return watch.stopped() && done < all ? Result<std::vector<int>>(stopped())
                                       : Result<std::vector<int>>(std::move(changed));
}

Result<std::vector<int>> EditedCamera::spectral(const CameraMatting& matting, const std::vector<bool>& stale,
                                                const RemakeWatch& watch) {
  const int count = take_->frame_count();
  if (!spectral_) {
    Result<SpectralTake> created = SpectralTake::create(
        *take_, camera_, *key_, spectral_cache(take_->layout(), options_.serial), options_.threads);
    if (!created) return forward(created);
    spectral_.emplace(std::move(*created));
  }
  if (!prepared_) {
    std::mutex mutex;
    int done = 0;
    const Result<void> ok = spectral_->prepare([&](int) {
      std::lock_guard lock(mutex);
      watch.progress("matting components", ++done, count);
      return !watch.stopped();
    });
    if (!ok) return forward(ok);
    prepared_ = true;
  }
  if (Result<void> ok = spectral_->say(matting); !ok) return forward(ok);
  idle_ = spectral_->idle();
  const std::vector<bool> reached = spectral_->reached(count);
  std::vector<int> changed;
  const int all = static_cast<int>(std::count(stale.begin(), stale.end(), true));
  int done = 0;
  for (int first = 0; first < count; ++first) {
    if (!stale[static_cast<std::size_t>(first)]) continue;
    int last = first;
    while (last + 1 < count && stale[static_cast<std::size_t>(last + 1)]) ++last;
    const Result<void> ok = spectral_->propagate(
        [&](int frame) {
          watch.progress(text("carrying the matte through frame ", frame), done, all);
          return !watch.stopped();
        },
        first, last);
    if (!ok) return forward(ok);
    for (int frame = first; frame <= last; ++frame) {
      if (watch.stopped()) return stopped();
      const Result<bool> other = put(frame, spectral_->matte(matting, frame));
      if (!other) return forward(other);
      if (reached[static_cast<std::size_t>(frame)]) record().guided.insert(frame);
      if (*other) changed.push_back(frame), watch.made(frame);
      watch.progress("mattes", ++done, all);
    }
    first = last;
  }
  return changed;
}

Result<matting::MattingComponents> EditedCamera::components(int frame) {
  if (prepared_) return spectral_->components(frame);
  const ScratchFolder scratch{fs::temp_directory_path() / text("floatstage-", getpid(), "-components")};
  return components_of_frame(*take_, camera_, frame, scratch.path);
}

Result<std::optional<double>> EditedCamera::flicker(int frame) {
  if (frame < 1 || !is_there(file(frame - 1)) || !is_there(file(frame))) return std::optional<double>();
  Image photographs[2], mattes[2];
  for (int i = 0; i < 2; ++i) {
    Result<Frame> photograph = take_->frame(camera_, frame - 1 + i);
    if (!photograph) return forward(photograph);
    if (photograph->empty()) return std::optional<double>();
    Result<Image> rgb = to_rgb(*photograph), matte = load_png(file(frame - 1 + i));
    if (!rgb) return forward(rgb);
    if (!matte) return forward(matte);
    photographs[i] = std::move(*rgb), mattes[i] = std::move(*matte);
  }
  const Result<double> flicker = matting::matte_flicker(photographs[0], mattes[0], photographs[1], mattes[1]);
  if (!flicker) return forward(flicker);
  return std::optional<double>(*flicker);
}

}  // namespace floatstage::pipeline
