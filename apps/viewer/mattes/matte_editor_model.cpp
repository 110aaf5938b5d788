#include "apps/viewer/mattes/matte_editor_model.h"

#include <algorithm>
#include <cmath>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/label_record.h"
#include "pipeline/made_files.h"
#include "pipeline/matte/affected_frames.h"

namespace floatstage::apps {
namespace {

constexpr int kMeteredAtOnce = 12;  // frames; then the time line shows them

double rounded(double seconds) { return std::round(seconds * 10) / 10; }

}  // namespace

Result<std::unique_ptr<MatteEditorModel>> MatteEditorModel::open(MatteEditorModelOptions options) {
  Result<std::unique_ptr<pipeline::EditedCamera>> edited = pipeline::EditedCamera::open(options.camera);
  if (!edited) return forward(edited);
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.camera.take);
  if (!take) return forward(take);
  if (options.frame < 0 || options.frame >= (*take)->frame_count())
    return fail(ErrorCode::InvalidArgument,
                text("frame ", options.frame, " is not in the take, which has ", (*take)->frame_count()));
  const int camera = camera_index((*take)->rig(), options.camera.serial);
  const CameraModel& model = (*take)->rig().cameras[static_cast<std::size_t>(camera)].model;
  if (model.width < 1 || model.height < 1)
    return fail(ErrorCode::BadData, text("camera '", options.camera.serial, "' has no size in rig.json"));
  return std::unique_ptr<MatteEditorModel>(
      new MatteEditorModel(std::move(options), std::move(*take), std::move(*edited)));
}

MatteEditorModel::MatteEditorModel(MatteEditorModelOptions options, std::unique_ptr<capture::TakeReader> take,
                                   std::unique_ptr<pipeline::EditedCamera> edited)
    : options_(std::move(options)),
      take_(std::move(take)),
      edited_(std::move(edited)),
      method_(edited_->how()),
      camera_(camera_index(take_->rig(), options_.camera.serial)),
      last_edits_(edited_->edits()) {
  const int frames = take_->frame_count();
  const CameraModel& model = take_->rig().cameras[static_cast<std::size_t>(camera_)].model;
  state_.reset(new EditorState{TimeLine(frames, take_->manifest().frame_rate),
                               EditSession(last_edits_, frames, model.width, model.height),
                               PictureFit(model.width, model.height)});
  state_->time.seek(options_.frame);
  state_->view = options_.view;
  state_->automatic = options_.automatic;
  state_->flicker.resize(static_cast<std::size_t>(frames));
  take_state();
  state_->status = text("camera '", serial(), "', mattes by ", method_,
                        std::count(state_->stale.begin(), state_->stale.end(), true) > 0
                            ? "; Enter makes the mattes that are missing"
                            : "");
  unmetered_.assign(static_cast<std::size_t>(frames), true);
  take_labels();
}

MatteEditorModel::~MatteEditorModel() { task_.stop(); }

// What is known of the mattes while nobody makes them.
void MatteEditorModel::take_state() {
  state_->stale = edited_->stale(last_edits_);
  state_->guided = edited_->guided();
  state_->doubts = edited_->doubts();
}

// Those of labels.json, of strokes in any camera, and those that somebody has written in this window.
void MatteEditorModel::take_labels() {
  const auto add = [this](const std::string& label) {
    std::vector<std::string>& labels = state_->labels;
    if (!label.empty() && std::find(labels.begin(), labels.end(), label) == labels.end())
      labels.push_back(label);
  };
  const Result<pipeline::LabelRecord> record = pipeline::load_label_record(take_->layout());
  if (!record) state_->status = record.error().message;
  if (record)
    for (const std::string& label : record->labels) add(label);
  if (const Result<MatteEdits> edits = load_matte_edits(take_->layout().edits()))
    for (const auto& [serial, camera] : edits->cameras)
      for (const MatteKeyframe& keyframe : camera.keyframes)
        for (const MatteStroke& stroke : keyframe.strokes) add(stroke.subject);
  for (const std::string& label : options_.labels) add(label);
  add(options_.subject);
  state_->session.subject = options_.subject;
}

bool MatteEditorModel::matte_exists(int frame) const {
  return is_there(take_->layout().matte(serial(), frame));
}

bool MatteEditorModel::busy() const {
  return task_.running() || pending_ || state_->time.playing ||
         std::count(unmetered_.begin(), unmetered_.end(), true) > 0;
}

std::optional<BackgroundTask::Progress> MatteEditorModel::progress() const {
  if (!task_.running()) return std::nullopt;
  return task_.progress();
}

// Edits of other cameras, which another window may have changed meanwhile, are kept.
bool MatteEditorModel::save_edits() {
  const std::filesystem::path file = take_->layout().edits();
  Result<MatteEdits> all = load_matte_edits(file);
  if (all) {
    if (state_->session.edits() == CameraEdits())
      all->cameras.erase(serial());
    else
      all->cameras[serial()] = state_->session.edits();
  }
  Result<void> ok = all ? make_folder(take_->layout().mattes()) : Result<void>(forward(all));
  if (ok) ok = save_matte_edits(*all, file);
  if (!ok) state_->status = text("not saved: ", ok.error().message);
  return ok.has_value();
}

void MatteEditorModel::answer(const EditorRequests& requests) {
  if (state_->question.empty() || !(requests.yes || requests.no)) return;
  state_->question.clear();
  if (requests.yes) {
    edited_->allow_replacing();
    pending_ = true;
  } else if (state_->session.undo()) {
    state_->status = "taken back; the mattes stay as they are";
    last_edits_ = state_->session.edits();
    state_->stale = edited_->stale(last_edits_);
    save_edits();
  }
}

void MatteEditorModel::apply(const EditorRequests& requests) {
  answer(requests);
  const CameraEdits& edits = state_->session.edits();
  if (requests.edited || !(edits == last_edits_)) {
    // Between two edits it does not matter what has been made of the first.
    const int frames = state_->time.frames();
    const std::vector<bool> more =
        method_ == "spectral"
            ? pipeline::frames_between_keyframes(last_edits_, edits, frames)
            : pipeline::downstream_of(pipeline::frames_chosen_otherwise(last_edits_, edits, frames), edits);
    for (std::size_t f = 0; f < more.size(); ++f) state_->stale[f] = state_->stale[f] || more[f];
    last_edits_ = edits;
    state_->question.clear();
    state_->status.clear();
    if (job_ == Job::Remake) task_.stop();
    pending_ = save_edits() && (pending_ || job_ == Job::Remake || state_->automatic);
  }
  if (requests.remake && save_edits()) pending_ = true;
  if (pending_ && job_ != Job::None && job_ != Job::Remake) task_.stop();
}

// Frames whose mattes lie on disk since the last look.
void MatteEditorModel::collect_made() {
  std::vector<int> made;
  {
    std::lock_guard lock(outcome_.mutex);
    made.swap(outcome_.made);
  }
  const std::size_t frames = state_->flicker.size();
  for (const int frame : made) {
    const std::size_t f = static_cast<std::size_t>(frame);
    state_->stale[f] = false;
    for (std::size_t g = f; g < std::min(f + 2, frames); ++g)
      state_->flicker[g].reset(), unmetered_[g] = true;
    if (shown_ && (shown_->frame == frame || shown_->frame == frame + 1)) shown_.reset();
  }
  if (!made.empty()) state_->worst = worst_frames(state_->flicker);
}

void MatteEditorModel::end_job() {
  const Job ended = std::exchange(job_, Job::None);
  if (ended == Job::Remake) {
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - job_began_).count();
    const Result<std::vector<int>>& made = outcome_.remade;
    if (made) {
      take_state();
      state_->status = text(serial(), ": ", made->size(), " mattes changed in ", rounded(seconds), " s");
      if (!edited_->idle().empty()) state_->status += text("; ", edited_->idle().front());
      if (!edited_->ended().empty())
        state_->status += text("; ", edited_->ended().front(),
                               edited_->ended().size() > 1
                                   ? text(" (and ", edited_->ended().size() - 1, " more, red on the line)")
                                   : "");
      if (!edited_->failures().empty()) state_->status = edited_->failures().front();
      options_.say(state_->status);
    } else if (made.error().code == ErrorCode::AlreadyExists) {
      state_->question = made.error().message;
      options_.say(state_->question);
    } else if (made.error().code != ErrorCode::Cancelled) {
      state_->status = made.error().message;
      options_.say(state_->status);
    }
    shown_.reset();
  } else if (ended == Job::Components) {
    components_frame_ =
        outcome_.frame;  // also when there are none: it is not tried again until the frame changes
    components_ = outcome_.components ? std::move(*outcome_.components) : matting::MattingComponents();
    if (!outcome_.components) state_->status = outcome_.components.error().message;
    shown_.reset();
  } else if (ended == Job::Flicker) {
    for (const auto& [frame, value] : outcome_.flicker)
      state_->flicker[static_cast<std::size_t>(frame)] = value;
    for (const int frame : outcome_.unasked) unmetered_[static_cast<std::size_t>(frame)] = true;
    if (outcome_.flicker_error) state_->status = outcome_.flicker_error->message;
    state_->worst = worst_frames(state_->flicker);
  }
}

void MatteEditorModel::begin_remake() {
  pending_ = false;
  job_ = Job::Remake;
  job_began_ = std::chrono::steady_clock::now();
  task_.start([this, edits = last_edits_] {
    pipeline::RemakeWatch watch;
    watch.stopped = [this] { return task_.stopped(); };
    watch.progress = [this](const std::string& what, int done, int all) { task_.report(what, done, all); };
    watch.made = [this](int frame) {
      std::lock_guard lock(outcome_.mutex);
      outcome_.made.push_back(frame);
    };
    outcome_.remade = edited_->remake(edits, watch);
  });
}

void MatteEditorModel::begin_components() {
  job_ = Job::Components;
  outcome_.frame = state_->time.frame();
  task_.start([this] {
    task_.report(text("components of frame ", outcome_.frame), 0, 1);
    outcome_.components = edited_->components(outcome_.frame);
  });
}

bool MatteEditorModel::begin_flicker() {
  std::vector<int> frames;
  for (std::size_t f = 0; f < unmetered_.size() && frames.size() < kMeteredAtOnce; ++f) {
    if (!unmetered_[f]) continue;
    unmetered_[f] = false;
    if (f > 0 && matte_exists(static_cast<int>(f)) && matte_exists(static_cast<int>(f) - 1))
      frames.push_back(static_cast<int>(f));
  }
  if (frames.empty()) return false;
  job_ = Job::Flicker;
  outcome_.flicker.clear();
  outcome_.unasked.clear();
  outcome_.flicker_error.reset();
  task_.start([this, frames] {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (task_.stopped()) {
        outcome_.unasked.push_back(frames[i]);
        continue;
      }
      task_.report("flicker", static_cast<int>(i), static_cast<int>(frames.size()));
      const Result<std::optional<double>> value = edited_->flicker(frames[i]);
      if (!value) outcome_.flicker_error = value.error();
      if (value && *value) outcome_.flicker.emplace_back(frames[i], **value);
    }
  });
  return true;
}

void MatteEditorModel::begin_job() {
  if (pending_) return begin_remake();
  if (state_->view == MatteView::Components && components_frame_ != state_->time.frame() &&
      !state_->time.playing)
    return begin_components();
  begin_flicker();
}

void MatteEditorModel::collect() {
  collect_made();
  if (task_.finished()) {
    collect_made();
    end_job();
  }
  if (!task_.running()) begin_job();
}

Image MatteEditorModel::load_matte(int frame) const {
  if (frame < 0 || !matte_exists(frame)) return {};
  Result<Image> matte = load_png(take_->layout().matte(serial(), frame));
  return matte ? std::move(*matte) : Image();
}

// What has changed since the labels of a frame were made, empty where nothing has.
std::string MatteEditorModel::labels_lag(int frame) const {
  const TakeLayout layout = take_->layout();
  const Result<pipeline::LabelRecord> record = pipeline::load_label_record(layout);
  if (!record) return record.error().message;
  const Result<std::optional<std::string>> sum = pipeline::hash_of(layout.matte(serial(), frame));
  if (!sum) return sum.error().message;
  if (const auto camera = record->sums.find(serial()); *sum && camera != record->sums.end()) {
    const auto known = camera->second.find(frame);
    if (known == camera->second.end() || known->second != **sum)
      return "the labels are older than this matte; `floatstage matte` divides it anew";
  }
  std::error_code error;
  const auto said = std::filesystem::last_write_time(layout.edits(), error);
  if (error) return {};
  const auto made = std::filesystem::last_write_time(layout.label_record(), error);
  if (error || made >= said) return {};
  return "strokes have changed since the mattes were divided; `floatstage matte` divides them anew";
}

// Each label's matte; what there is to say of them is in the status.
std::vector<Image> MatteEditorModel::load_labels(int frame) {
  std::vector<Image> labels;
  bool any = false;
  for (const std::string& label : state_->labels) {
    const std::filesystem::path file = take_->layout().label_matte(serial(), label, frame);
    Result<Image> matte = is_there(file) ? load_png(file) : Result<Image>(Image());
    labels.push_back(matte ? std::move(*matte) : Image());
    any = any || !labels.back().empty();
  }
  if (!any)
    state_->status = "no labels of this frame; name them by strokes (L), and `floatstage matte` divides it";
  else if (const std::string lag = labels_lag(frame); !lag.empty())
    state_->status = lag;
  return labels;
}

void MatteEditorModel::show() {
  const Shown wanted{state_->time.frame(), state_->view};
  if (shown_ == wanted) return;
  shown_ = wanted;
  ++picture_number_;
  if (photograph_frame_ != wanted.frame) {
    photograph_frame_ = wanted.frame;
    photograph_ = {};
    const Result<Frame> frame = take_->frame(camera_, wanted.frame);
    Result<Image> rgb = frame && !frame->empty() ? to_rgb(*frame) : Result<Image>(Image());
    if (!frame || !rgb) state_->status = frame ? rgb.error().message : frame.error().message;
    if (rgb) photograph_ = std::move(*rgb);
  }
  MatteViewInput in{
      .photograph = photograph_, .matte = load_matte(wanted.frame), .before = {}, .components = {}};
  has_matte_ = !in.matte.empty();
  if (wanted.view == MatteView::Difference) in.before = load_matte(wanted.frame - 1);
  if (wanted.view == MatteView::Labels) in.labels = load_labels(wanted.frame);
  if (wanted.view == MatteView::Components && components_frame_ == wanted.frame) in.components = components_;
  picture_ = photograph_.empty() ? Image() : matte_picture(wanted.view, in);
}

void MatteEditorModel::update(double seconds) {
  state_->time.advance(seconds);
  collect();
  show();
}

}  // namespace floatstage::apps
