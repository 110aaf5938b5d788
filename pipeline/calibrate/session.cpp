#include "pipeline/calibrate/session.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <toml++/toml.h>

#include "core/file.h"
#include "core/rig.h"
#include "core/text.h"
#include "pipeline/calibrate/session_patterns.h"

namespace floatstage::pipeline {
namespace {

// One table whose keys must all be known. The first complaint is kept; reading goes on with defaults after
// it.
class Table {
 public:
  Table(const toml::table& table, std::string where, std::optional<std::string>& problem)
      : table_(table), where_(std::move(where)), problem_(problem) {}

  const toml::node* node(const char* key) {
    asked_.insert(key);
    return table_.get(key);
  }
  void string(const char* key, std::string& out) {
    if (const toml::node* n = node(key)) take(*n, key, n->value_exact<std::string>(), "a string \"…\"", out);
  }
  void path(const char* key, std::filesystem::path& out) {
    std::string word;
    string(key, word);
    if (!word.empty()) out = word;
  }
  void paths(const char* key, std::vector<std::filesystem::path>& out) {
    const toml::node* n = node(key);
    if (!n) return;
    if (const auto one = n->value_exact<std::string>()) {
      out = {*one};
      return;
    }
    const toml::array* list = n->as_array();
    for (std::size_t i = 0; list && i < list->size(); ++i)
      if (const auto one = list->get(i)->value_exact<std::string>())
        out.push_back(*one);
      else
        complain(*n, text("'", key, "' is a list of strings"));
    if (!list || list->empty()) complain(*n, text("'", key, "' is a string or a list of at least one"));
  }
  void number(const char* key, double& out, double least, double most) {
    const toml::node* n = node(key);
    if (!n) return;
    const std::optional<double> v = n->value<double>();
    if (!v || !n->is_number() || !(*v >= least && *v <= most))
      complain(*n, text("'", key, "' is a number from ", least, " to ", most));
    else
      out = *v;
  }
  void whole(const char* key, int& out, int least, int most) {
    const toml::node* n = node(key);
    if (!n) return;
    const std::optional<std::int64_t> v = n->value_exact<std::int64_t>();
    if (!v || *v < least || *v > most)
      complain(*n, text("'", key, "' is a whole number from ", least, " to ", most));
    else
      out = static_cast<int>(*v);
  }
  void boolean(const char* key, bool& out) {
    if (const toml::node* n = node(key)) take(*n, key, n->value_exact<bool>(), "true or false", out);
  }
  template <class Enum>
  void one_of(const char* key, std::initializer_list<std::pair<const char*, Enum>> words, Enum& out) {
    const toml::node* n = node(key);
    if (!n) return;
    std::string all;
    for (const auto& [word, value] : words) {
      if (n->value_exact<std::string>() == word) {
        out = value;
        return;
      }
      all += text(all.empty() ? "" : ", ", '"', word, '"');
    }
    complain(*n, text("'", key, "' is one of ", all));
  }
  std::optional<Table> child(const char* key) {
    const toml::node* n = node(key);
    if (!n) return std::nullopt;
    if (const toml::table* t = n->as_table()) return Table(*t, where_, problem_);
    complain(*n, text("'", key, "' is a table [", key, "]"));
    return std::nullopt;
  }
  std::vector<Table> children(const char* key) {
    std::vector<Table> out;
    const toml::node* n = node(key);
    if (!n) return out;
    const toml::array* list = n->as_array();
    for (std::size_t i = 0; list && i < list->size(); ++i)
      if (const toml::table* t = list->get(i)->as_table()) out.emplace_back(*t, where_, problem_);
    if (!list || out.size() != list->size())
      complain(*n, text("'", key, "' are tables, each begun by [[", key, "]]"));
    return out;
  }
  void refuse_others() {
    for (const auto& [key, value] : table_)
      if (!asked_.contains(key.str()))
        complain(value, text("unknown key '", key.str(), "'; is it misspelt?"));
  }
  void complain(const toml::node& at, const std::string& what) {
    if (!problem_) problem_ = text(where_, ": line ", at.source().begin.line, ": ", what);
  }
  void complain(const std::string& what) { complain(table_, what); }

 private:
  template <class T>
  void take(const toml::node& n, const char* key, const std::optional<T>& value, const char* what, T& out) {
    if (value)
      out = *value;
    else
      complain(n, text("'", key, "' is ", what));
  }
  const toml::table& table_;
  std::string where_;
  std::optional<std::string>& problem_;
  std::set<std::string_view, std::less<>> asked_;
};

constexpr int kMostFrames = 1'000'000;
constexpr double kLarge = 1e6;

// Which terms of the lens are solved for.
void read_terms(Table& t, SessionCamera& c) {
  const int most = c.lens == calib::LensKind::KannalaBrandt  ? 4
                   : c.lens == calib::LensKind::BrownConrady ? 6
                                                             : 0;
  if (t.node("radial")) t.whole("radial", c.terms.radial.emplace(most), 0, most);
  t.boolean("tangential", c.terms.tangential);
  t.boolean("skew", c.terms.skew);
}

SessionCamera read_camera(Table t) {
  SessionCamera c;
  t.string("serial", c.serial);
  t.one_of("lens",
           {{"none", calib::LensKind::None},
            {"brown-conrady", calib::LensKind::BrownConrady},
            {"kannala-brandt", calib::LensKind::KannalaBrandt}},
           c.lens);
  read_terms(t, c);
  t.path("video", c.video);
  t.paths("images", c.images);
  t.paths("alone", c.alone);
  t.paths("scene", c.scene);
  t.boolean("carried", c.carried);
  if (c.serial.empty() ? !is_camera_pattern(c) : !is_usable_serial(c.serial))
    t.complain(text("'serial' names a camera by letters, digits, '.', '_' and '-', not '", c.serial,
                    "'; without it, paths have {serial} where cameras differ"));
  if (!c.serial.empty() && is_camera_pattern(c))
    t.complain(
        text("camera '", c.serial, "' has {serial} in a path, which stands for cameras without a 'serial'"));
  if (!c.video.empty() && !c.images.empty())
    t.complain(text("camera '", c.serial, "' has a 'video' and 'images'; give one of them"));
  if (c.video.empty() && c.images.empty() && c.alone.empty() && c.scene.empty())
    t.complain(text("camera '", c.serial, "' has no pictures; give 'video', 'images', 'alone' or 'scene'"));
  if (c.carried && (c.scene.empty() || !c.video.empty() || !c.images.empty() || !c.alone.empty()))
    t.complain(
        text("camera '", c.serial, "' is carried about: it has pictures of the 'scene' and no others"));
  t.refuse_others();
  return c;
}

SessionPoint read_point(Table t) {
  SessionPoint p;
  t.string("name", p.name);
  if (const toml::node* n = t.node("seen")) {
    const toml::table* seen = n->as_table();
    if (!seen) t.complain(*n, "'seen' is a table { camera = [x, y], … }");
    for (const auto& [serial, place] : seen ? *seen : toml::table{}) {
      const toml::array* xy = place.as_array();
      const auto x = xy && xy->size() == 2 ? xy->get(0)->value<double>() : std::nullopt;
      const auto y = xy && xy->size() == 2 ? xy->get(1)->value<double>() : std::nullopt;
      if (x && y && std::abs(*x) <= kLarge && std::abs(*y) <= kLarge)
        p.seen.push_back({std::string(serial.str()), {*x, *y}});
      else
        t.complain(place, text("camera '", serial.str(), "' sees a point at [x, y], in pixels"));
    }
  }
  if (p.seen.size() < 2) t.complain(text("point '", p.name, "' is not seen by two cameras"));
  t.refuse_others();
  return p;
}

SessionKnown read_known(Table t) {
  SessionKnown k;
  t.path("file", k.file);
  t.string("format", k.format);
  if (k.format != calib::kAnyRigFormat) {
    if (const Result<const calib::RigFormat*> format = calib::rig_format(k.format, k.file); !format)
      t.complain(*t.node("format"), text("'format': ", format.error().message));
    else if ((*format)->states_unit && t.node("metres_per_unit"))
      t.complain(*t.node("metres_per_unit"),
                 text("'metres_per_unit' is for formats that state no unit, which ", k.format, " does"));
  }
  t.number("metres_per_unit", k.metres_per_unit, 1e-6, kLarge);
  const std::initializer_list<std::pair<const char*, calib::Prior>> priors = {
      {"compare", calib::Prior::Unknown}, {"start", calib::Prior::Start}, {"fixed", calib::Prior::Fixed}};
  t.one_of("intrinsics", priors, k.intrinsics);
  t.one_of("poses", priors, k.poses);
  if (k.file.empty()) t.complain("'file' is missing: where what is known is written");
  t.refuse_others();
  return k;
}

SessionMarkerless read_markerless(Table t) {
  SessionMarkerless m;
  std::vector<std::filesystem::path> between;
  t.paths("between", between);
  if (between.size() == 2) {
    m.a = between[0].string();
    m.b = between[1].string();
  } else if (!between.empty()) {
    t.complain("'between' names two cameras");
  }
  t.number("distance", m.distance, 1e-3, kLarge);
  double sigma_mm = 1e3 * m.sigma;
  t.number("sigma_mm", sigma_mm, 1e-3, 1e5);
  m.sigma = 1e-3 * sigma_mm;
  if (m.a.empty() != (m.distance == 0))
    t.complain("'between' and 'distance' belong together: two cameras, and the metres between their centres");
  t.number("timeout", m.timeout, 1, kLarge);
  t.number("least_track", m.least_track, 2, 1000);
  t.whole("least_points", m.least_points, 10, kMostFrames);
  t.number("contrast", m.contrast, 1e-4, 1);
  t.one_of("lens",
           {{"known", UnknownLenses::Refused},
            {"shared", UnknownLenses::Shared},
            {"separate", UnknownLenses::Separate}},
           m.lens);
  t.number("focal_px", m.focal_px, 1, kLarge);
  double percent = 100 * m.largest_focal_error;
  t.number("largest_focal_error_percent", percent, 0.01, 100);
  m.largest_focal_error = percent / 100;
  double ring_percent = 0;
  t.number("ring_percent", ring_percent, 1e-3, 30);
  m.ring = ring_percent / 100;
  t.refuse_others();
  return m;
}

SessionVolume read_volume(Table t) {
  SessionVolume v;
  for (const auto& [key, corner] : {std::pair{"low", &v.low}, std::pair{"high", &v.high}}) {
    const toml::node* n = t.node(key);
    const toml::array* list = n ? n->as_array() : nullptr;
    bool good = list && list->size() == 3;
    for (std::size_t i = 0; good && i < 3; ++i) {
      const std::optional<double> value = list->get(i)->value<double>();
      good = value && std::abs(*value) <= kLarge;
      if (good) (*corner)[static_cast<Eigen::Index>(i)] = *value;
    }
    if (!good) t.complain(text("'", key, "' of [volume] is [x, y, z] in metres of the world"));
  }
  if (!((v.high - v.low).minCoeff() > 0)) t.complain("'high' of [volume] lies beyond 'low' along every axis");
  t.refuse_others();
  return v;
}

void read_options(Table t, Session& s) {
  calib::CalibrationOptions& o = s.options;
  t.boolean("time_offsets", o.time_offsets);
  t.whole("holdout_every", o.holdout_every, 0, kMostFrames);
  t.number("outlier_sigmas", o.outlier_sigmas, 2, 100);
  t.number("least_depth_ratio", o.least_depth_ratio, 1, 100);
  t.number("least_tilt_degrees", o.least_tilt_degrees, 0, 90);
  t.number("largest_length_error", o.largest_length_error, 0, 1);
  t.number("late_frames", o.late_frames, 0.01, 100);
  t.refuse_others();
}

void read_bars(Table t, CalibrationBars& b) {
  t.number("rms_px", b.rms_px, 0, kLarge);
  t.number("p95_px", b.p95_px, 0, kLarge);
  t.number("holdout_ratio", b.holdout_ratio, 0, kLarge);
  t.number("scale_rms_mm", b.scale_rms_mm, 0, kLarge);
  t.number("scale_bias_mm", b.scale_bias_mm, 0, kLarge);
  t.number("focal_sigma_percent", b.focal_sigma_percent, 0, kLarge);
  t.number("rotation_sigma_degrees", b.rotation_sigma_degrees, 0, kLarge);
  t.number("points_px", b.points_px, 0, kLarge);
  t.number("projection_sigma_px", b.projection_sigma_px, 0, kLarge);
  if (t.node("known_center_percent"))
    t.number("known_center_percent", b.known_center_percent.emplace(0), 0, kLarge);
  t.refuse_others();
}

void read_target(Table& t, Session& s) {
  std::string words;
  t.string("target", words);
  if (words.empty()) return;
  Result<calib::TargetDesign> design = calib::parse_target(words);
  if (design)
    s.target = std::move(*design);
  else
    t.complain(*t.node("target"), design.error().message);
}

void check_whole(Table& t, const Session& s) {
  const auto shows_target = [](const SessionCamera& c) {
    return !c.video.empty() || !c.images.empty() || !c.alone.empty();
  };
  const bool targets = !s.markerless || std::any_of(s.cameras.begin(), s.cameras.end(), shows_target);
  for (const SessionCamera& c : s.cameras)
    if (!c.scene.empty() && !s.markerless)
      t.complain(text("camera '", c.serial, "' has pictures of the 'scene'; they need a table [markerless]"));
  const bool patterns = std::any_of(s.cameras.begin(), s.cameras.end(), is_camera_pattern);
  if (s.markerless && !patterns &&
      std::count_if(s.cameras.begin(), s.cameras.end(),
                    [](const SessionCamera& c) { return !c.scene.empty(); }) < 2)
    t.complain("[markerless] needs two cameras or more with a picture of the 'scene'");
  for (const std::string& serial : {s.markerless ? s.markerless->a : "", s.markerless ? s.markerless->b : ""})
    if (!serial.empty() && !patterns &&
        std::none_of(s.cameras.begin(), s.cameras.end(), [&](const SessionCamera& c) {
          return c.serial == serial && !c.scene.empty() && !c.carried;
        }))
      t.complain(text("'between' names camera '", serial, "', which has no picture of the 'scene'"));
  if (s.observations.empty() && targets && !s.target)
    t.complain("'target' is missing: what the pictures show, e.g. target = \"charuco columns=5 …\"");
  if (s.observations.empty() && s.cameras.empty())
    t.complain("there is no camera; begin each with [[cameras]]");
  if (!s.observations.empty() && (s.target || !s.cameras.empty()))
    t.complain("'observations' hold targets and cameras already; leave 'target' and [[cameras]] out");
  std::set<std::string> serials;
  for (const SessionCamera& c : s.cameras)
    if (!c.serial.empty() && !serials.insert(c.serial).second)
      t.complain(text("camera '", c.serial, "' stands there twice"));
  if (s.end_frame && *s.end_frame <= s.first_frame) t.complain("'end_frame' is not after 'first_frame'");
}

void make_relative(std::filesystem::path& p, const std::filesystem::path& folder) {
  if (!p.empty() && p.is_relative()) p = (folder / p).lexically_normal();
}

}  // namespace

Result<Session> parse_session(std::string_view toml_text, std::string_view name) {
  toml::table document;
  try {
    document = toml::parse(toml_text);
  } catch (const toml::parse_error& e) {
    return fail(ErrorCode::BadData,
                text(name, ": line ", e.source().begin.line, ": not TOML: ", e.description()));
  }
  Session s;
  std::optional<std::string> problem;
  Table t(document, std::string(name), problem);
  read_target(t, s);
  t.path("observations", s.observations);
  t.number("frame_rate", s.frame_rate, 0, 10'000);
  t.whole("first_frame", s.first_frame, 0, kMostFrames);
  t.whole("every", s.every, 1, kMostFrames);
  if (document.contains("end_frame")) t.whole("end_frame", s.end_frame.emplace(kMostFrames), 1, kMostFrames);
  double wand_sigma_mm = 1e3 * s.wand_sigma;
  t.number("wand_sigma_mm", wand_sigma_mm, 1e-6, 1000);
  s.wand_sigma = 1e-3 * wand_sigma_mm;
  for (Table& camera : t.children("cameras")) s.cameras.push_back(read_camera(std::move(camera)));
  for (Table& point : t.children("points")) s.points.push_back(read_point(std::move(point)));
  if (std::optional<Table> known = t.child("known")) s.known = read_known(std::move(*known));
  if (std::optional<Table> floor = t.child("floor")) {
    s.floor.emplace();
    double height_mm = 0;
    floor->whole("frame", s.floor->frame, 0, kMostFrames);
    floor->number("height_mm", height_mm, -1000, 1000);
    s.floor->height = 1e-3 * height_mm;
    floor->refuse_others();
  }
  if (std::optional<Table> markerless = t.child("markerless")) {
    s.markerless = read_markerless(std::move(*markerless));
    s.options.ring = s.markerless->ring;
  }
  if (std::optional<Table> volume = t.child("volume")) s.volume = read_volume(std::move(*volume));
  if (std::optional<Table> options = t.child("options")) read_options(std::move(*options), s);
  if (std::optional<Table> bars = t.child("bars")) read_bars(std::move(*bars), s.bars);
  t.refuse_others();
  check_whole(t, s);
  if (problem) return fail(ErrorCode::BadData, *problem);
  return s;
}

Result<Session> load_session(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  Result<Session> session = parse_session(*bytes, file.string());
  if (!session) return session;
  const std::filesystem::path folder = file.parent_path();
  make_relative(session->observations, folder);
  if (session->known) make_relative(session->known->file, folder);
  for (SessionCamera& c : session->cameras) {
    make_relative(c.video, folder);
    for (std::filesystem::path& p : c.images) make_relative(p, folder);
    for (std::filesystem::path& p : c.alone) make_relative(p, folder);
    for (std::filesystem::path& p : c.scene) make_relative(p, folder);
  }
  if (Result<void> ok = expand_patterns(*session); !ok)
    return fail(ok.error().code, text(file.string(), ": ", ok.error().message));
  return session;
}

}  // namespace floatstage::pipeline
