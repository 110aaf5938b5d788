#include "pipeline/matte/edited_camera.h"

#include <algorithm>
#include <mutex>

#include <unistd.h>

#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/keying.h"
#include "pipeline/matte/affected_frames.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

Unexpected stopped() { return fail(ErrorCode::Cancelled, "stopped; what was finished is kept"); }

// Whether a picture was recorded there, as far as the side file knows.
bool recorded(const capture::TakeReader& take, int camera, int frame) {
  const std::vector<FrameRow>& rows = take.rows(camera);
  return static_cast<std::size_t>(frame) < rows.size() && rows[static_cast<std::size_t>(frame)].media_index;
}

// Removed when it goes out of scope: components that are only to be looked at are not kept in the take.
struct ScratchFolder {
  fs::path path;
  ~ScratchFolder() {
    std::error_code none;
    fs::remove_all(path, none);
  }
};

}  // namespace

EditedCamera::EditedCamera(std::unique_ptr<capture::TakeReader> take, int camera, EditedCameraOptions options)
    : take_(std::move(take)), camera_(camera), options_(std::move(options)) {}

Result<std::unique_ptr<EditedCamera>> EditedCamera::open(const EditedCameraOptions& options) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.take);
  if (!take) return forward(take);
  const int camera = camera_index((*take)->rig(), options.serial);
  if (camera < 0)
    return fail(ErrorCode::InvalidArgument,
                text(options.take.string(), " has no camera '", options.serial, "'"));
  const std::vector<MatteMethod>& methods = matte_methods();
  if (!options.method.empty() && std::none_of(methods.begin(), methods.end(),
                                              [&](const MatteMethod& m) { return m.name == options.method; }))
    return fail(ErrorCode::InvalidArgument,
                text("no method is called '", options.method, "'; see `floatstage matte --help`"));
  Result<std::map<std::string, CameraRecord>> records = load_matting((*take)->layout());
  if (!records) return forward(records);
  Result<MatteEdits> edits = load_matte_edits((*take)->layout().edits());
  if (!edits) return forward(edits);
  std::unique_ptr<EditedCamera> edited(new EditedCamera(std::move(*take), camera, options));
  edited->on_disk_ = edits->cameras[options.serial];
  const auto found = records->find(options.serial);
  edited->by_matte_ = found != records->end();
  if (edited->by_matte_) edited->record_ = found->second;
  CameraRecord& record = edited->record_;
  const std::string method = !options.method.empty() ? options.method
                             : edited->by_matte_     ? record.method
                                                     : "auto";
  const std::string guide = options.method.empty() ? record.guide : options.guide.string();
  const bool same = edited->by_matte_ && record.method == method && record.guide == guide;
  if (same && record.edits == fingerprint(edited->on_disk_)) edited->made_for_ = edited->on_disk_;
  if (!same) record = {method, "", "", guide, ""};
  return edited;
}

std::vector<bool> EditedCamera::changed_since(const CameraEdits& edits) const {
  const int count = take_->frame_count();
  if (!made_for_) return std::vector<bool>(static_cast<std::size_t>(count), true);
  // What was cut out from strokes as a whole, other strokes cut out as a whole.
  if (record_.key == "cut" && !same_strokes(*made_for_, edits))
    return std::vector<bool>(static_cast<std::size_t>(count), true);
  std::vector<bool> out = record_.chosen == "spectral" ? frames_between_keyframes(*made_for_, edits, count)
                                                       : frames_chosen_otherwise(*made_for_, edits, count);
  for (int f = 0; f < count; ++f)
    if (record_.stale.contains(f) || (recorded(*take_, camera_, f) && !fs::exists(file(f))))
      out[static_cast<std::size_t>(f)] = true;
  return out;
}

std::vector<bool> EditedCamera::stale(const CameraEdits& edits) const {
  return record_.chosen == "spectral" ? changed_since(edits) : downstream_of(changed_since(edits), edits);
}

Result<void> EditedCamera::make_key(const CameraEdits& edits, const RemakeWatch& watch) {
  if (key_ && key_->uses_strokes() && !same_strokes(key_edits_, edits))
    key_.reset(), spectral_.reset(), prepared_ = false;
  if (!key_) {
    watch.progress("key", 0, 1);
    Result<CameraKey> key = CameraKey::for_method(*take_, camera_, record_.method, record_.guide, edits,
                                                  [&] { return !watch.stopped(); });
    if (!key) return forward(key);
    if (Result<void> ok = key->ready(); !ok) return ok;
    key_.emplace(std::move(*key));
    key_edits_ = edits;
    const bool other = key_->kind() == CameraKey::Kind::Cut && made_for_ && !same_strokes(*made_for_, edits);
    if (other) made_for_.reset(), record_.chosen.clear();
    if (record_.key != key_->spec())
      made_for_.reset(), record_.chosen.clear();  // a plate was shot since, or there were no mattes
    record_.key = key_->spec();
  }
  if (!record_.chosen.empty()) return {};
  Result<std::string> chosen = CameraMatting(*take_, camera_, *key_, {}, record_.method).chosen_method();
  if (!chosen) return forward(chosen);
  record_.chosen = std::move(*chosen);
  return {};
}

Result<void> EditedCamera::save_record() {
  Result<std::map<std::string, CameraRecord>> all = load_matting(take_->layout());
  if (!all) return forward(all);
  (*all)[options_.serial] = record_;
  return save_matting(*all, take_->layout());
}

// From here on the record speaks of these edits, and of the mattes that are not theirs yet.
Result<void> EditedCamera::begin(const CameraEdits& edits, const std::vector<bool>& stale) {
  const fs::path folder = take_->layout().mattes() / options_.serial;
  if (Result<void> ok = make_folder(folder); !ok) return ok;
  sweep_temporaries(folder);
  record_.edits = fingerprint(edits);
  record_.stale.clear();
  for (std::size_t f = 0; f < stale.size(); ++f)
    if (stale[f] && fs::exists(file(static_cast<int>(f)))) record_.stale.insert(static_cast<int>(f));
  if (Result<void> ok = save_record(); !ok) return ok;
  made_for_ = edits;
  by_matte_ = true;
  const Result<std::optional<KeyingRecord>> keying = load_keying(take_->layout(), take_->rig());
  if (!keying) return forward(keying);
  return *keying ? Result<void>()
                 : save_keying({"matte:" + record_.method, {}}, take_->layout(), take_->rig());
}

Result<std::vector<int>> EditedCamera::remake(const CameraEdits& edits, const RemakeWatch& watch) {
  failures_.clear();
  std::error_code none;
  const fs::path folder = take_->layout().mattes() / options_.serial;
  if (!by_matte_ && !options_.replace && fs::exists(folder) && !fs::is_empty(folder, none))
    return fail(
        ErrorCode::AlreadyExists,
        text(folder.string(),
             " was not made by `matte`, so it is not changed; say --redo to let the editor make it again"));
  if (Result<void> ok = make_key(edits, watch); !ok) return forward(ok);
  if (watch.stopped()) return stopped();
  const std::vector<bool> forced = changed_since(edits), wanted = stale(edits);
  if (Result<void> ok = begin(edits, wanted); !ok) return forward(ok);
  const CameraMatting matting(*take_, camera_, *key_, edits, record_.chosen);
  Result<std::vector<int>> changed =
      record_.chosen == "spectral" ? spectral(matting, wanted, watch) : follow(matting, forced, watch);
  if (changed) record_.stale.clear();
  if (Result<void> ok = save_record(); !ok) return changed ? Result<std::vector<int>>(forward(ok)) : changed;
  return changed;
}

// Puts a matte into its place. Whether another one lies there now.
Result<bool> EditedCamera::put(int frame, Result<Image> matte) {
  const fs::path path = file(frame);
  const bool there = fs::exists(path);
  if (!matte && matte.error().code == ErrorCode::Io) return forward(matte);
  if (!matte)
    failures_.push_back(text("camera '", options_.serial, "', frame ", frame, ": ", matte.error().message));
  bool changed = there;
  if (!matte || matte->empty()) {
    std::error_code error;
    fs::remove(path, error);
    if (error) return fail(ErrorCode::Io, text("cannot remove ", path.string(), ": ", error.message()));
  } else {
    const Result<Image> old = there ? load_png(path) : Result<Image>(Image());
    changed = !old || *old != *matte;
    if (changed)
      if (Result<void> ok = save_png(*matte, path); !ok) return forward(ok);
  }
  record_.stale.erase(frame);
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
  const auto make = [&](int frame, const Image& previous) -> CameraMatting::Link {
    Result<Image> matte = matting.matte(frame, previous);
    CameraMatting::Link link;
    if (matte) link.matte = *matte;
    std::lock_guard lock(mutex);
    const Result<bool> other = put(frame, std::move(matte));
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
               (wanted[static_cast<std::size_t>(f)] || !fs::exists(file(f)));
      };
      return at(frame - 1) || at(frame + 1);
    };
    matting.follow(go_on, [&](int frame, const CameraMatting::Link& previous) -> CameraMatting::Link {
      if (forced[static_cast<std::size_t>(frame)] || previous.changed) return make(frame, previous.matte);
      record_.stale.erase(frame);
      if (wanted[static_cast<std::size_t>(frame)]) watch.progress("mattes", ++done, all);
      if (!any_wanted_beyond(frame) || !fs::exists(file(frame))) return {};
      Result<Image> matte = load_png(file(frame));
      return {matte ? std::move(*matte) : Image(), false};
    });
  }
  if (failure) return Unexpected{*failure};
  if (watch.stopped() && !record_.stale.empty()) return stopped();
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
  if (frame < 1 || !fs::exists(file(frame - 1)) || !fs::exists(file(frame))) return std::optional<double>();
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
