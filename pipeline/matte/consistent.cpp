#include "pipeline/matte/consistent.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/known_by_plate.h"
#include "matting/view_colors.h"
#include "matting/view_cut.h"
#include "pipeline/matte/consistent_verdict.h"
#include "pipeline/matte/corrected_key.h"
#include "pipeline/matte/stage_evidence.h"
#include "recon/occupancy.h"
#include "recon/shared_view.h"

namespace floatstage::pipeline {
namespace {

using matting::Certain;
using recon::OccupancyGrid;

constexpr float kColor = 4;           // log-odds at most by colours …
constexpr float kKey = 1;             // … of a key's word, beside colours and the others' word
constexpr float kBeforeStill = 0.5f;  // … of which so much counts where a backdrop stands still …
constexpr float kMostOthers = 2, kLeastOthers = -4;  // … and by what the others say
constexpr float kAllAgree = 1.5f;                    // log-odds of a place that all others hold for subject
constexpr double kFirstNovelty = 0.2, kNovelty = 0.05;  // of the subject's colours, before and after a cut
constexpr double kBorder = 0.06;  // of the shorter side: held for background where nothing is known yet
constexpr double kCore = 0.4, kAround = 0.8;  // of the shared ball: where the subject is looked for first
constexpr double kNearBorder = 0.1, kFarFromBorder = 0.5;  // of the edges that enclose the core
constexpr double kNearAmidst = 0.05;                       // likewise around the core: skin before white
constexpr double kMargin = 0.2;        // of the subject's size: space around it that stays in question
constexpr double kSettled = 0.0005;    // share of pixels: less change than that, and the turns end
constexpr int kNear = 3;               // px at the turns' size: too near the subject to be held for backdrop
constexpr double kBridged = 1.0 / 30;  // of the longer side: half of a gap in him that is bridged
constexpr int kKeyTurns = 4;           // at most, where keys begin
constexpr int kGridTurns = 2;          // turns after which the grid is laid closer around the subject

struct View {
  int w = 0, h = 0;
  Image small, label;
  std::vector<float> keyed, odds, others, share;
  std::vector<Certain> certain;
  bool there() const { return !small.empty(); }
  std::size_t pixels() const { return static_cast<std::size_t>(w) * static_cast<std::size_t>(h); }
};

// By a square.
Image grown(const Image& mask, int r) {
  Image from = mask;
  for (const bool across : {true, false}) {
    Image to = from;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        for (int s = -r; s <= r && !*to.at(x, y); ++s) {
          const int qx = x + (across ? s : 0), qy = y + (across ? 0 : s);
          if (qx >= 0 && qy >= 0 && qx < mask.width && qy < mask.height && *from.at(qx, qy))
            *to.at(x, y) = 255;
        }
    from = std::move(to);
  }
  return from;
}

Image inverted(Image mask) {
  for (std::uint8_t& v : mask.pixels) v = v ? 0 : 255;
  return mask;
}

Result<void> in_range(bool ok, const char* what) {
  if (!ok) return fail(ErrorCode::InvalidArgument, what);
  return {};
}

}  // namespace

Result<void> ConsistentOptions::check() const {
  if (working_pixels < 2'000 || working_pixels > 1'000'000)
    return fail(ErrorCode::InvalidArgument,
                text("working_pixels is ", working_pixels, ", not 2000 … 1000000"));
  if (voxels < 10'000 || voxels > 10'000'000)
    return fail(ErrorCode::InvalidArgument, text("voxels is ", voxels, ", not 10000 … 10000000"));
  if (Result<void> ok = in_range(turns >= 1 && turns <= 50, "turns are 1 … 50"); !ok) return ok;
  if (Result<void> ok = in_range(later_turns >= 1 && later_turns <= 50, "later_turns are 1 … 50"); !ok)
    return ok;
  return in_range(smooth >= 0 && smooth <= 100 && threads >= 0, "smooth is 0 … 100, threads not negative");
}

struct ConsistentMatting::Impl {
  Impl(const Rig& r, const std::vector<Eigen::Vector2i>& s) : rig(r), sizes(s), stages(r, s) {
    for (const Eigen::Vector2i& size : sizes) {
      View& view = views.emplace_back();
      view.w = size.x();
      view.h = size.y();
    }
  }

  Rig rig;
  ConsistentOptions options;
  recon::SharedView shared;
  std::vector<View> views;
  std::vector<Eigen::Vector2i> sizes;
  std::unique_ptr<OccupancyGrid> grid;
  std::optional<matting::ViewColors> colors;
  StageEvidence stages;
  bool heard = false;  // of changes of light, from a grid that lies where this one lies

  template <class Body>
  void each(const Body& body) {
    parallel_for(views.size(), options.threads, [&](std::size_t i) {
      if (views[i].there()) body(i, views[i]);
    });
  }
  // Log-odds of a place that half of a camera's fellows hold for subject, and nobody for background.
  double agreement_of_half() const {
    const auto there = std::count_if(views.begin(), views.end(), [](const View& v) { return v.there(); });
    return 0.5 * std::log(1 / recon::OccupancyOptions().seen_anyway) * static_cast<double>(there - 1);
  }

  Result<void> check_backdrop(int camera, const std::vector<Image>& pictures) const;
  Result<void> look(std::span<const Image> pictures, std::span<const Image> said);
  void see(std::span<const Image> pictures);
  void begin();
  void believe(std::span<const Image> keys);
  void begin_view(std::size_t camera, View& view) const;
  void learn(double novelty);
  void weigh_colors();
  void ask_others();
  double cut();
  double turn();
  Result<int> take_turns(const std::function<bool()>& go_on);
  void lay_grid(const Eigen::AlignedBox3d& box) {
    grid = std::make_unique<OccupancyGrid>(rig, box, options.voxels, sizes, shared.seen_by, options.threads);
    heard = false;
  }
  void close_in();
  void follow();
  void judge_views(ConsistentMattes& out) const;
  Result<std::vector<Image>> finish(std::span<const Image> pictures, std::span<const Image> said) const;
};

Result<void> ConsistentMatting::Impl::check_backdrop(int camera, const std::vector<Image>& pictures) const {
  const View& v = views.at(static_cast<std::size_t>(camera));
  for (const Image& p : pictures)
    if (p.width != v.w || p.height != v.h || p.channels != 3)
      return fail(ErrorCode::InvalidArgument, text("a backdrop's pictures are RGB and ", v.w, "x", v.h));
  return {};
}

Result<void> ConsistentMatting::Impl::look(std::span<const Image> pictures, std::span<const Image> said) {
  if (pictures.size() != views.size() || (!said.empty() && said.size() != views.size()))
    return fail(ErrorCode::InvalidArgument,
                text("there are ", views.size(), " cameras, not ", pictures.size()));
  int there = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const CameraModel& m = rig.cameras[i].model;
    const auto fits = [&](const Image& image, int channels) {
      return image.empty() ||
             (image.width == m.width && image.height == m.height && image.channels == channels);
    };
    if (!fits(pictures[i], 3) || (!said.empty() && !fits(said[i], 1)))
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", rig.cameras[i].serial, "': pictures must be RGB and ", m.width, "x",
                       m.height, ", and what is said of them too"));
    there += !pictures[i].empty();
  }
  if (there < 2) return fail(ErrorCode::BadData, "fewer than two cameras have a photograph of this instant");
  see(pictures);
  if (said.empty()) return {};
  each([&](std::size_t i, View& v) {
    if (said[i].empty()) return;
    v.certain.assign(v.pixels(), Certain::No);
    for (int y = 0; y < said[i].height; ++y)
      for (int x = 0; x < said[i].width; ++x) {
        const int word = *said[i].at(x, y);
        if (word != 0 && word != 255) continue;
        v.certain[static_cast<std::size_t>(y * v.h / said[i].height) * static_cast<std::size_t>(v.w) +
                  static_cast<std::size_t>(x * v.w / said[i].width)] =
            word ? Certain::Subject : Certain::Backdrop;
      }
  });
  return {};
}

// `pictures`: of the photographs' sizes, or of those of the turns.
void ConsistentMatting::Impl::see(std::span<const Image> pictures) {
  parallel_for(views.size(), options.threads, [&](std::size_t i) {
    View& v = views[i];
    v.small = pictures[i].empty() ? Image() : matting::shrunk(pictures[i], v.w, v.h);
    v.certain.clear();
    v.keyed.clear();
  });
  std::vector<Image> smaller;
  for (const View& v : views) smaller.push_back(v.small);
  stages.look(pictures, smaller, options.threads);
  heard = false;
}

// Before anything was cut: the border is background, and so is what hardly an edge separates from it; what
// edges enclose around the fixation is subject; the rest is not learnt from.
void ConsistentMatting::Impl::begin_view(std::size_t camera, View& v) const {
  const RigCamera& c = rig.cameras[camera];
  const StageEvidence::View& stage = stages.of(camera);
  const Eigen::Vector3d fixation = c.cam_from_world * shared.fixation;
  std::vector<float> off(v.pixels()), inner;
  const std::vector<float> edges = matting::edges_to_border(v.small);
  for (std::size_t p = 0; p < off.size(); ++p) {
    const int x = static_cast<int>(p) % v.w, y = static_cast<int>(p) / v.w;
    const auto ray = unproject(c.model, {(x + 0.5) / v.w * c.model.width, (y + 0.5) / v.h * c.model.height});
    off[p] = ray && fixation.z() > 0 ? static_cast<float>(fixation.cross(ray->normalized()).norm()) : 1e9f;
    if (off[p] < kCore * shared.radius) inner.push_back(edges[p]);
  }
  if (inner.empty()) inner = edges;
  const std::size_t high = inner.size() * 9 / 10;
  std::nth_element(inner.begin(), inner.begin() + static_cast<std::ptrdiff_t>(high), inner.end());
  const double enclosed = inner[high];
  const int band = std::max(1, static_cast<int>(std::lround(kBorder * std::min(v.w, v.h))));
  v.share.assign(v.pixels(), -1);
  for (std::size_t p = 0; p < off.size(); ++p) {
    const int x = static_cast<int>(p) % v.w, y = static_cast<int>(p) / v.w;
    const bool around = off[p] < kAround * shared.radius;
    if (x < band || y < band || x >= v.w - band || y >= v.h - band ||
        edges[p] < (around ? kNearAmidst : kNearBorder) * enclosed)
      v.share[p] = 0;
    else if (around && edges[p] > kFarFromBorder * enclosed)
      v.share[p] = 1;
    if (stage.tells_of(p)) {
      // What may be the stage in a shadow, or grey trousers before a grey one, is left to the others.
      const bool far = off[p] >= 2 * shared.radius;
      v.share[p] = far || stage.odds[p] < 0 ? 0.0f : stage.odds[p] > 0 ? 1.0f : -1.0f;
    }
    if (!v.certain.empty() && v.certain[p] != Certain::No) v.share[p] = v.certain[p] == Certain::Subject;
  }
}

void ConsistentMatting::Impl::begin() {
  lay_grid(shared.box);
  each([&](std::size_t i, View& v) {
    v.label = {};
    begin_view(i, v);
  });
}

// What keys have told is where the turns begin, and counts in each of them.
void ConsistentMatting::Impl::believe(std::span<const Image> keys) {
  lay_grid(shared.box);
  each([&](std::size_t i, View& v) {
    v.label = {};
    v.share.assign(v.pixels(), -1);
    v.keyed.assign(v.pixels(), 0);
    if (keys[i].empty()) return;
    const Image small = matting::shrunk(keys[i], v.w, v.h);
    for (std::size_t p = 0; p < v.keyed.size(); ++p) {
      v.share[p] = static_cast<float>(small.pixels[p]) / 255;
      v.keyed[p] = kKey * (2 * v.share[p] - 1);
    }
  });
}

void ConsistentMatting::Impl::learn(double novelty) {
  std::vector<Image> pictures;
  std::vector<std::vector<float>> shares;
  for (const View& v : views) {
    pictures.push_back(v.small);
    shares.push_back(v.there() ? v.share : std::vector<float>());
  }
  colors.emplace(pictures, shares, novelty, options.threads);
}

void ConsistentMatting::Impl::weigh_colors() {
  each([&](std::size_t i, View& v) {
    const StageEvidence::View& stage = stages.of(i);
    v.odds = colors->odds(static_cast<int>(i), v.small);
    for (std::size_t p = 0; p < v.odds.size(); ++p) {
      const float by_color = std::clamp(v.odds[p], -kColor, kColor);
      v.odds[p] =
          stage.tells_of(p) ? std::clamp(kBeforeStill * by_color + stage.odds[p], -kColor, kColor) : by_color;
      if (stage.may_hide_shadow(p)) v.odds[p] -= kAllAgree;  // which all agree on where his shadow shows, too
      if (!v.keyed.empty()) v.odds[p] = std::clamp(v.odds[p] + v.keyed[p], -kColor, kColor);
      if (!v.certain.empty() && v.certain[p] != Certain::No)
        v.odds[p] = v.certain[p] == Certain::Subject ? kColor : -kColor;
    }
  });
}

// What cameras say of one another is brought to one scale: as if all others agreed, or half of them.
void ConsistentMatting::Impl::ask_others() {
  std::vector<recon::OddsPicture> odds(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i].there()) odds[i] = {views[i].w, views[i].h, views[i].odds};
  grid->fuse(odds, {});
  const double half = agreement_of_half();
  each([&](std::size_t i, View& v) {
    v.others = grid->said_by_others(static_cast<int>(i));
    for (float& s : v.others)
      if (s > OccupancyGrid::kNothing / 2) s = static_cast<float>(kAllAgree * (s - half) / half);
  });
}

double ConsistentMatting::Impl::cut() {
  std::vector<double> changed(views.size());
  each([&](std::size_t i, View& v) {
    std::vector<float> sum(v.pixels());
    for (std::size_t p = 0; p < sum.size(); ++p)
      sum[p] = v.odds[p] + std::clamp(v.others[p], kLeastOthers, kMostOthers);
    const StageEvidence::View& stage = stages.of(i);
    Image label = matting::cut_view(v.small, sum, v.certain, options.smooth,
                                    stage.lit ? stage.lit->empty_stage() : Image(), stage.shadow);
    std::size_t different = 0;
    v.share.resize(v.pixels());
    for (std::size_t p = 0; p < sum.size(); ++p) {
      different += v.label.empty() || v.label.pixels[p] != label.pixels[p];
      v.share[p] = label.pixels[p] ? 1.0f : 0.0f;
    }
    changed[i] = static_cast<double>(different) / static_cast<double>(sum.size());
    v.label = std::move(label);
  });
  return *std::max_element(changed.begin(), changed.end());
}

// Share of the pixels of the picture that changes most.
double ConsistentMatting::Impl::turn() {
  if (!heard)
    heard = stages.hear_others(*grid, shared, static_cast<float>(agreement_of_half()), options.threads);
  weigh_colors();
  ask_others();
  return cut();
}

void ConsistentMatting::Impl::close_in() {
  Eigen::AlignedBox3d box = grid->subject_box(static_cast<float>(agreement_of_half()));
  if (box.isEmpty()) return;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMargin * box.sizes().maxCoeff());
  box = Eigen::AlignedBox3d(box.min() - margin, box.max() + margin).intersection(shared.box);
  if (box.volume() < 0.8 * grid->box().volume()) lay_grid(box);
}

// Lays the grid anew where the subject comes near its sides.
void ConsistentMatting::Impl::follow() {
  const Eigen::AlignedBox3d box = grid->subject_box(static_cast<float>(agreement_of_half()));
  if (box.isEmpty()) return;
  const auto around = [&](double margin) {
    const Eigen::Vector3d m = Eigen::Vector3d::Constant(margin * box.sizes().maxCoeff());
    return Eigen::AlignedBox3d(box.min() - m, box.max() + m).intersection(shared.box);
  };
  if (!grid->box().contains(around(kMargin / 2))) lay_grid(around(kMargin));
}

// Of the pictures that were looked at; the next instant begins with what these leave.
Result<int> ConsistentMatting::Impl::take_turns(const std::function<bool()>& go_on) {
  const bool first = !colors;
  if (first) begin();
  int turns = 0;
  for (double changed = 1; turns < (first ? options.turns : options.later_turns) && changed > kSettled;) {
    if (go_on && !go_on()) return fail(ErrorCode::Cancelled, "stopped while the views were made consistent");
    if (first || turns > 0) learn(first && turns == 0 ? kFirstNovelty : kNovelty);
    changed = turn();
    if (++turns <= kGridTurns && first) close_in();
  }
  learn(kNovelty);
  follow();
  return turns;
}

void ConsistentMatting::Impl::judge_views(ConsistentMattes& out) const {
  std::vector<ViewEvidence> evidence;
  for (const View& v : views) evidence.push_back({v.there() ? v.label : Image(), v.odds, v.others});
  judge(rig, shared, evidence, out);
}

Result<std::vector<Image>> ConsistentMatting::Impl::finish(std::span<const Image> pictures,
                                                           std::span<const Image> said) const {
  std::vector<Result<Image>> made(pictures.size(), Image());
  parallel_for(pictures.size(), options.threads, [&](std::size_t i) {
    if (!views[i].there()) return;
    const View& v = views[i];
    const Image told = said.empty() ? Image() : said[i];
    const std::optional<matting::PlateWord>& word = stages.of(i).word;
    Image known = word ? matting::known_by_plate(*word, v.label, v.odds) : told;
    const auto say = [&](Image& to) {
      for (std::size_t p = 0; p < told.pixels.size(); ++p)
        if (told.pixels[p] == 0 || told.pixels[p] == 255) to.pixels[p] = told.pixels[p];
    };
    if (word) say(known);
    if (options.refine)
      made[i] = matting::refine_matte(pictures[i], v.label, matting::key_refinement(), known);
    else
      made[i] = matting::shrunk(v.label, pictures[i].width, pictures[i].height);
    if (made[i]) say(*made[i]);
  });
  std::vector<Image> mattes;
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (!made[i])
      return fail(made[i].error().code,
                  text("camera '", rig.cameras[i].serial, "': ", made[i].error().message));
    mattes.push_back(std::move(*made[i]));
  }
  return mattes;
}

ConsistentMatting::ConsistentMatting(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ConsistentMatting::ConsistentMatting(ConsistentMatting&&) noexcept = default;
ConsistentMatting& ConsistentMatting::operator=(ConsistentMatting&&) noexcept = default;
ConsistentMatting::~ConsistentMatting() = default;

Result<ConsistentMatting> ConsistentMatting::create(const Rig& rig, const ConsistentOptions& options) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  Result<recon::SharedView> shared = recon::shared_view(rig);
  if (!shared) return forward(shared);
  std::vector<Eigen::Vector2i> sizes;
  for (const RigCamera& c : rig.cameras) {
    const CameraModel& m = c.model;
    const double shrink =
        std::min(1.0, std::sqrt(options.working_pixels / (static_cast<double>(m.width) * m.height)));
    const auto side = [&](int px) { return std::max(3, static_cast<int>(std::lround(px * shrink))); };
    sizes.emplace_back(side(m.width), side(m.height));
  }
  auto impl = std::make_unique<Impl>(rig, sizes);
  impl->options = options;
  impl->shared = *shared;
  return ConsistentMatting(std::move(impl));
}

Eigen::Vector2i ConsistentMatting::working_size(int camera) const {
  return impl_->sizes.at(static_cast<std::size_t>(camera));
}

Result<void> ConsistentMatting::learn_backdrop(int camera, const std::vector<Image>& pictures,
                                               const std::vector<Image>& subjects) {
  if (Result<void> ok = impl_->check_backdrop(camera, pictures); !ok) return ok;
  Result<matting::StillBackdrop> backdrop = matting::StillBackdrop::learn(pictures, subjects);
  if (!backdrop) return forward(backdrop);
  impl_->stages.learn(static_cast<std::size_t>(camera), std::move(*backdrop));
  return {};
}

Result<void> ConsistentMatting::learn_empty_stage(int camera, matting::Plate plate) {
  const View& v = impl_->views.at(static_cast<std::size_t>(camera));
  const CameraModel& m = impl_->rig.cameras[static_cast<std::size_t>(camera)].model;
  if (plate.color.width != m.width || plate.color.height != m.height || plate.color.channels != 3)
    return fail(ErrorCode::InvalidArgument, text("a plate is RGB and ", m.width, "x", m.height));
  Result<matting::StillBackdrop> backdrop =
      matting::StillBackdrop::of_empty_stage({matting::shrunk(plate.color, v.w, v.h)});
  if (!backdrop) return forward(backdrop);
  impl_->stages.learn(static_cast<std::size_t>(camera), std::move(plate), std::move(*backdrop));
  return {};
}

Result<std::vector<Image>> ConsistentMatting::surroundings(std::span<const Image> pictures, Margin margin,
                                                           const std::function<bool()>& go_on) {
  Impl& m = *impl_;
  if (pictures.size() != m.views.size())
    return fail(ErrorCode::InvalidArgument,
                text("there are ", m.views.size(), " cameras, not ", pictures.size()));
  int there = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const View& v = m.views[i];
    there += !pictures[i].empty();
    if (!pictures[i].empty() &&
        (pictures[i].width != v.w || pictures[i].height != v.h || pictures[i].channels != 3))
      return fail(ErrorCode::InvalidArgument, text("these pictures are RGB and ", v.w, "x", v.h));
  }
  if (there < 2) return fail(ErrorCode::BadData, "fewer than two cameras have a photograph of this instant");
  m.see(pictures);
  if (Result<int> turns = m.take_turns(go_on); !turns) return forward(turns);
  std::vector<Image> near(pictures.size());
  m.each([&](std::size_t i, View& v) {
    const int wide = static_cast<int>(std::lround(kBridged * std::max(v.w, v.h)));
    if (margin == Margin::Bridged && wide > kNear)
      near[i] = inverted(grown(inverted(grown(v.label, wide)), wide - kNear));
    else
      near[i] = grown(v.label, kNear);
  });
  return near;
}

void ConsistentMatting::forget() {
  impl_->colors.reset();
  impl_->grid.reset();
  impl_->stages.forget();
}

int ConsistentMatting::walls() const { return impl_->stages.walls(); }

Result<ConsistentMattes> ConsistentMatting::matte(std::span<const Image> pictures,
                                                  std::span<const Image> said,
                                                  const std::function<bool()>& go_on) {
  Impl& m = *impl_;
  if (Result<void> ok = m.look(pictures, said); !ok) return forward(ok);
  ConsistentMattes out;
  const Result<int> turns = m.take_turns(go_on);
  if (!turns) return forward(turns);
  out.turns = *turns;
  m.judge_views(out);
  if (Result<std::vector<Image>> mattes = m.finish(pictures, said); mattes)
    out.mattes = std::move(*mattes);
  else
    return forward(mattes);
  return out;
}

Result<ConsistentMattes> ConsistentMatting::reconcile(std::span<const Image> pictures,
                                                      std::span<const Image> keys) {
  Impl& m = *impl_;
  if (keys.size() != m.views.size())
    return fail(ErrorCode::InvalidArgument,
                text("there are ", m.views.size(), " cameras, not ", keys.size()));
  if (Result<void> ok = m.look(pictures, keys); !ok) return forward(ok);
  for (View& v : m.views) v.certain.clear();  // keys are no certainty
  m.believe(keys);
  ConsistentMattes out;
  for (double changed = 1; out.turns < kKeyTurns && changed > kSettled;) {
    m.learn(kNovelty);
    changed = m.turn();
    if (++out.turns <= kGridTurns) m.close_in();
  }
  m.judge_views(out);
  forget();
  std::vector<Result<Image>> corrected(keys.size(), Image());
  parallel_for(keys.size(), m.options.threads, [&](std::size_t i) {
    if (!keys[i].empty() && m.views[i].there())
      corrected[i] = corrected_key(pictures[i], keys[i], m.views[i].label);
  });
  for (Result<Image>& one : corrected) {
    if (!one) return forward(one);
    out.mattes.push_back(std::move(*one));
  }
  return out;
}

}  // namespace floatstage::pipeline
