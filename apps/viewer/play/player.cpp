#include "apps/viewer/play/player.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <imgui.h>

#include "apps/viewer/play/film_job.h"
#include "apps/viewer/play/panels.h"
#include "apps/viewer/play/path_strip.h"
#include "apps/viewer/play/scene_cache.h"
#include "apps/viewer/play/sound_lead.h"
#include "apps/viewer/window/layout.h"
#include "capture/sound/sound_record.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/balance.h"
#include "pipeline/label_record.h"
#include "pipeline/orbit.h"
#include "pipeline/take_fields.h"
#include "render/camera_grid.h"

namespace floatstage::apps {
namespace {

constexpr float kTimeLineHeight = 62, kPathHeight = PathStrip::kHeight + 4;

Result<int> method_index(const std::vector<std::string>& methods, const std::string& name) {
  const auto found = std::find(methods.begin(), methods.end(), name);
  if (found != methods.end()) return static_cast<int>(found - methods.begin());
  std::string known;
  for (const std::string& m : methods) known += " " + m;
  return fail(ErrorCode::InvalidArgument, text("there is no method '", name, "'; there are:", known));
}

// Which of the take's labels are seen: all, where none is named.
void mark(const std::vector<std::string>& labels, PlayerState& state) {
  for (PlayerState::Who& who : state.who)
    who.shown = labels.empty() || std::find(labels.begin(), labels.end(), who.label) != labels.end();
}

class WindowPlayer : public Player {
 public:
  WindowPlayer(const PlayOptions& options, capture::TakeReader& take, const Rig& rig,
               const Eigen::AlignedBox3d& subject, PlayerState state)
      : options_(options),
        take_(take),
        labels_(options.labels),
        home_(state.camera.key()),
        cache_(std::make_unique<SceneCache>(take)),
        canvas_(rig, subject),
        state_(std::move(state)),
        sound_(open_sound()),
        lead_(sound_.get()) {}

  void frame(std::span<const InputEvent> input) override {
    move_on(ImGui::GetIO().DeltaTime);
    take_shortcuts(input, home_, state_);
    strip_.take(input, state_);
    load();
    give_fields();
    lay_out(input);
    finish_film();
  }

  void frame_took(double seconds) override {
    canvas_.window_took(seconds);
    constexpr double kLast = 0.3, kMost = 0.25;
    ahead_ += kLast * (std::min(seconds, kMost) - ahead_);
    note_what_is_heard();
  }
  void give_up_when(std::function<bool()> hand_waits) override {
    canvas_.give_up_when(std::move(hand_waits));
  }
  bool gave_up() const override { return canvas_.gave_up(); }
  bool stands() const override { return shown_ == state_.time.frame() && canvas_.has_full_picture(); }
  const CanvasTimes& times() const override { return canvas_.times(); }
  const std::vector<ShownWhileHeard>& shown_while_heard() const override { return heard_; }
  bool busy() const override { return state_.time.playing || shown_ != state_.time.frame() || film_; }
  int frame_number() const override { return state_.time.frame(); }
  void go_to(int frame) override { state_.time.seek(frame); }
  void show_status(std::string status) override { state_.status = std::move(status); }
  void forget_scenes() override {
    cache_->clear();
    shown_ = -1;
  }

 private:
  void advance_path(double seconds) {
    const double duration = state_.path.path().duration();
    if (!(duration > 0)) return;
    state_.path_time = std::fmod(state_.path_time + seconds * state_.time.speed, duration);
    state_.seek_by_path();
  }

  // The output is opened when the take is, so that what is wrong with it is said once.
  std::unique_ptr<SoundPlayer> open_sound() {
    const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take_.layout());
    if (!options_.sound || !tracks || tracks->empty()) return nullptr;
    Result<std::unique_ptr<capture::SoundOutput>> output = capture::open_sound_output(options_.sound_output);
    if (!output) {
      without_sound(output.error().message);
      return nullptr;
    }
    std::string problem;
    std::unique_ptr<SoundPlayer> player = SoundPlayer::of_take(take_, std::move(*output), problem);
    if (!problem.empty()) without_sound(problem);
    if (!player) return nullptr;
    state_.sounds = player->tracks();
    const auto named = std::find(state_.sounds.begin(), state_.sounds.end(), options_.track);
    if (named != state_.sounds.end()) state_.sound = static_cast<int>(named - state_.sounds.begin());
    return player;
  }

  void without_sound(const std::string& why) {
    log::warning(text("nothing is heard: ", why));
    state_.status = text("nothing is heard: ", why);
  }

  void move_on(double elapsed) {
    if (sound_) {
      sound_->choose(state_.sound);
      sound_->set_gain(state_.muted ? 0 : state_.volume);
    }
    const bool by_path =
        state_.follow_path && state_.path.path().duration() > 0 && state_.path.path().has_take_times();
    lead_.advance(state_.time, elapsed, ImGui::GetTime(), ahead_, by_path);
    if (state_.follow_path && state_.time.playing) advance_path(elapsed);
    if (sound_)
      if (const std::optional<std::string> problem = sound_->take_problem()) without_sound(*problem);
  }

  void note_what_is_heard() {
    constexpr std::size_t kMost = 20'000;
    if (!lead_.heard() || shown_ == noted_ || heard_.size() >= kMost) return;
    const std::optional<double> heard = sound_->heard();
    if (!heard) return;
    heard_.push_back({shown_, sound_->output_clock(), *heard});
    noted_ = shown_;
  }

  void load() {
    int frame = state_.time.frame();
    // Where loading takes longer than frames follow one another, the newest that is there is shown, and what
    // is loaded is what will be due then.
    if (state_.time.playing) {
      const std::optional<int> newest = cache_->newest(shown_, frame);
      const double later = cache_->load_seconds() * state_.time.rate() * state_.time.speed;
      const int next = frame + std::max(newest == frame || shown_ == frame ? 1 : 0, static_cast<int>(later));
      cache_->prefetch(state_.time.loop ? next % state_.time.frames()
                                        : std::min(next, state_.time.frames() - 1));
      if (!newest) return;
      frame = *newest;
    }
    Result<std::shared_ptr<const SceneFrame>> scene = cache_->get(frame);
    if (!scene) {
      state_.status = scene.error().message;
      shown_ = frame;
      return;
    }
    if (!*scene) return;
    if (Result<void> ok = canvas_.show(*scene); !ok)
      state_.status = text("frame ", frame, ": ", ok.error().message);
    if (shown_ != frame) has_fields_ = false;
    shown_ = frame;
  }

  // Those that lie beside the take, once the method that draws with them is chosen.
  void give_fields() {
    const auto draws = [&](int method) {
      return state_.methods[static_cast<std::size_t>(method)] == pipeline::kFieldMethod;
    };
    if (has_fields_ || shown_ < 0 || !(draws(state_.left) || (state_.split && draws(state_.right)))) return;
    has_fields_ = true;
    if (Result<void> ok = pipeline::give_fields(seen().layout(), take_.rig(), shown_, canvas_.scene()); !ok)
      state_.status = ok.error().message;
  }

  void lay_out(std::span<const InputEvent> input) {
    PanelRequests requests;
    lay_out_window(kTimeLineHeight + (state_.path.empty() ? 0 : kPathHeight), state_.renderer.background,
                   {.controls =
                        [&] {
                          requests = draw_controls(state_, canvas_.render_milliseconds(),
                                                   film_ ? film_->pictures() : -1);
                        },
                    .strip = [&] { draw_time_line(state_, strip_); },
                    .stage =
                        [&] {
                          if (Result<void> ok = canvas_.draw(state_, input); !ok)
                            state_.status = ok.error().message;
                        }});
    apply_camera_requests(requests, home_, state_);
    if (requests.who) choose_labels();
    if (requests.render_film) begin_film();
  }

  const capture::TakeReader& seen() const { return chosen_ ? *chosen_ : take_; }

  // Others are seen, where they have meshes; else those from before.
  void choose_labels() {
    pipeline::LabelChoice wanted;
    for (const PlayerState::Who& who : state_.who)
      if (!who.shown) wanted.without.push_back(who.label);
    Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(options_.take, wanted);
    Result<pipeline::Subject> subject =
        take ? pipeline::find_subject(**take) : Result<pipeline::Subject>(forward(take));
    if (!subject) {
      mark(seen().layout().labels(), state_);
      state_.status = subject.error().message;
      return;
    }
    cache_ = std::make_unique<SceneCache>(**take);  // what loads from the reader before ends first
    chosen_ = std::move(*take);
    labels_ = std::move(wanted);
    state_.track = std::move(subject->track);
    state_.status.clear();
    shown_ = -1;
  }

  void begin_film() {
    if (state_.path.path().keys.size() < 2) {
      state_.status = "a film needs a path of two keys at least; walk and press K";
      return;
    }
    pipeline::FilmOptions film{.frames = {},
                               .methods = {state_.methods[static_cast<std::size_t>(state_.left)]},
                               .renderer = state_.renderer};
    film.seconds = state_.path.path().duration();
    for (int f = 0; f < state_.time.frames(); ++f) film.frames.push_back(f);
    film_.emplace(options_.take, labels_, state_.path.path(), film, state_.film_file);
    state_.status = text("rendering ", state_.film_file);
  }

  void finish_film() {
    if (!film_ || !film_->done()) return;
    const Result<pipeline::FilmReport> report = film_->result();
    state_.status =
        report ? text(state_.film_file, ": ", report->pictures, " pictures",
                      report->sight.much > 0 ? text(", ", report->sight.much, " of them in part unseen") : "")
               : report.error().message;
    film_.reset();
  }

  const PlayOptions& options_;
  capture::TakeReader& take_;
  std::unique_ptr<capture::TakeReader> chosen_;  // since others than at first are seen
  pipeline::LabelChoice labels_;
  const pipeline::PathKey home_;
  std::unique_ptr<SceneCache> cache_;
  Canvas canvas_;
  PlayerState state_;
  PathStrip strip_;
  std::optional<FilmJob> film_;
  int shown_ = -1;
  bool has_fields_ = false;                   // of the shown instant, as far as there are any
  const std::unique_ptr<SoundPlayer> sound_;  // null where nothing is heard
  SoundLead lead_;
  double ahead_ = 0;  // s from when a frame is chosen until it is seen
  std::vector<ShownWhileHeard> heard_;
  int noted_ = -1;
};

Result<PlayerState> initial_state(const PlayOptions& options, const capture::TakeReader& take,
                                  const pipeline::Subject& subject) {
  if (options.frame < 0 || options.frame >= take.frame_count())
    return fail(ErrorCode::InvalidArgument,
                text("frame ", options.frame, " is not in the take, which has ", take.frame_count()));
  // Home lies between two cameras: at a camera every method shows its photograph.
  const pipeline::PathKey home =
      pipeline::sample(pipeline::orbit_around(take.rig(), subject, {.seconds = 1}).path,
                       0.5 / static_cast<double>(take.rig().cameras.size()));
  PlayerState state{TimeLine(take.frame_count(), take.manifest().frame_rate), ViewerCamera(home)};
  const bool grid = render::camera_grid(take.rig().cameras).has_value();
  for (const render::RendererInfo& r : render::renderers())
    if (grid || !r.needs_grid) state.methods.push_back(r.name);
  Result<int> left = method_index(state.methods, options.method),
              right = method_index(state.methods, options.compare.empty() ? options.method : options.compare);
  if (!left) return forward(left);
  if (!right) return forward(right);
  for (const RigCamera& camera : take.rig().cameras) state.serials.push_back(camera.serial);
  const Result<pipeline::LabelRecord> labels = pipeline::load_label_record(take.layout());
  if (!labels) return forward(labels);
  for (const std::string& label : labels->labels) state.who.push_back({label});
  mark(take.layout().labels(), state);
  state.left = *left;
  state.right = *right;
  state.split = !options.compare.empty();
  state.renderer = options.renderer;
  state.quick = true;
  state.show_cameras = options.show_cameras;
  state.track = subject.track;
  state.time.seek(options.frame);
  state.time.playing = options.playing;
  state.status = text(options.take.string(), ": ", take.frame_count(), " frames of ",
                      take.rig().cameras.size(), " cameras");
  if (!options.path_file.empty()) {
    Result<pipeline::CameraPath> path = pipeline::load_path(options.path_file);
    if (!path) return forward(path);
    state.path.set(std::move(*path));
    state.path_file = options.path_file;
    state.follow_path = true;
    if (state.path.path().has_take_times() && options.frame == 0) state.seek_by_path();
  }
  return state;
}

}  // namespace

Result<void> Player::check(const PlayOptions& options, const capture::TakeReader& take) {
  const Result<pipeline::Subject> subject = pipeline::find_subject(take);
  if (!subject) return forward(subject);
  if (const Result<Rig> rig = pipeline::rig_with_colors(take); !rig) return forward(rig);
  if (options.sound && !options.track.empty()) {
    const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take.layout());
    if (!tracks) return forward(tracks);
    if (const auto track = capture::sound_track_named(*tracks, options.track); !track)
      return fail(track.error().code, text(options.take.string(), ": ", track.error().message));
  }
  const Result<PlayerState> state = initial_state(options, take, *subject);
  return state ? Result<void>() : Result<void>(forward(state));
}

Result<std::unique_ptr<Player>> Player::open(const PlayOptions& options, capture::TakeReader& take) {
  const Result<pipeline::Subject> subject = pipeline::find_subject(take);
  if (!subject) return forward(subject);
  const Result<Rig> rig = options.balance ? pipeline::rig_in_balance(take) : pipeline::rig_with_colors(take);
  if (!rig) return forward(rig);
  Result<PlayerState> state = initial_state(options, take, *subject);
  if (!state) return forward(state);
  return std::unique_ptr<Player>(new WindowPlayer(options, take, *rig, subject->box, std::move(*state)));
}

}  // namespace floatstage::apps
