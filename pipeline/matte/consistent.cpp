#include "pipeline/matte/consistent.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/view_colors.h"
#include "matting/view_cut.h"
#include "pipeline/matte/consistent_verdict.h"
#include "recon/occupancy.h"
#include "recon/shared_view.h"

namespace floatstage::pipeline {
namespace {

using matting::Certain;
using recon::OccupancyGrid;

constexpr float kColor = 4;           // log-odds at most by colours …
constexpr float kBeforeStill = 0.5f;  // … of which so much counts where a backdrop stands still …
constexpr float kMostOthers = 2, kLeastOthers = -4;  // … and by what the others say
constexpr double kAllAgree = 1.5;                    // log-odds of a place that all others hold for subject
constexpr double kFirstNovelty = 0.2, kNovelty = 0.05;  // of the subject's colours, before and after a cut
constexpr double kBorder = 0.06;  // of the shorter side: held for background where nothing is known yet
constexpr double kCore = 0.4, kAround = 0.8;  // of the shared ball: where the subject is looked for first
constexpr double kNearBorder = 0.1, kFarFromBorder = 0.5;  // of the edges that enclose the core
constexpr double kMargin = 0.2;      // of the subject's size: space around it that stays in question
constexpr double kSettled = 0.0005;  // share of pixels: less change than that, and the turns end
constexpr int kGridTurns = 2;        // turns after which the grid is laid closer around the subject

struct View {
  int w = 0, h = 0;
  Image small, label;
  std::vector<float> still, odds, others, share;
  std::vector<Certain> certain;
  std::optional<matting::StillBackdrop> backdrop;
  bool there() const { return !small.empty(); }
  std::size_t pixels() const { return static_cast<std::size_t>(w) * static_cast<std::size_t>(h); }
};

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
  Rig rig;
  ConsistentOptions options;
  recon::SharedView shared;
  std::vector<View> views;
  std::vector<Eigen::Vector2i> sizes;
  std::unique_ptr<OccupancyGrid> grid;
  std::optional<matting::ViewColors> colors;

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

  Result<void> look(std::span<const Image> pictures, std::span<const Image> said);
  void begin();
  void begin_view(std::size_t camera, View& view) const;
  void learn(double novelty);
  void weigh_colors();
  void ask_others();
  double cut();
  void lay_grid(const Eigen::AlignedBox3d& box) {
    grid = std::make_unique<OccupancyGrid>(rig, box, options.voxels, sizes, shared.seen_by, options.threads);
  }
  void close_in();
  void follow();
  Result<std::vector<Image>> finish(std::span<const Image> pictures, std::span<const Image> said) const;
};

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
  parallel_for(views.size(), options.threads, [&](std::size_t i) {
    View& v = views[i];
    v.small = pictures[i].empty() ? Image() : matting::shrunk(pictures[i], v.w, v.h);
    v.certain.clear();
    if (!v.there()) return;
    v.still = v.backdrop ? v.backdrop->odds(v.small) : std::vector<float>();
    if (said.empty() || said[i].empty()) return;
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

// Before anything was cut: the border is background, and so is what hardly an edge separates from it; what
// edges enclose around the fixation is subject; the rest is not learnt from.
void ConsistentMatting::Impl::begin_view(std::size_t camera, View& v) const {
  const RigCamera& c = rig.cameras[camera];
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
    if (x < band || y < band || x >= v.w - band || y >= v.h - band || edges[p] < kNearBorder * enclosed)
      v.share[p] = 0;
    else if (off[p] < kAround * shared.radius && edges[p] > kFarFromBorder * enclosed)
      v.share[p] = 1;
    if (!v.still.empty()) v.share[p] = v.still[p] > 0 && off[p] < 2 * shared.radius ? 1 : 0;
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
    v.odds = colors->odds(static_cast<int>(i), v.small);
    for (std::size_t p = 0; p < v.odds.size(); ++p) {
      const float by_color = std::clamp(v.odds[p], -kColor, kColor);
      v.odds[p] =
          v.still.empty() ? by_color : std::clamp(kBeforeStill * by_color + v.still[p], -kColor, kColor);
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
    Image label = matting::cut_view(v.small, sum, v.certain, options.smooth);
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

Result<std::vector<Image>> ConsistentMatting::Impl::finish(std::span<const Image> pictures,
                                                           std::span<const Image> said) const {
  std::vector<Result<Image>> made(pictures.size(), Image());
  parallel_for(pictures.size(), options.threads, [&](std::size_t i) {
    if (!views[i].there()) return;
    const Image keep = said.empty() ? Image() : said[i];
    if (options.refine)
      made[i] = matting::refine_matte(pictures[i], views[i].label, matting::key_refinement(), keep);
    else
      made[i] = matting::shrunk(views[i].label, pictures[i].width, pictures[i].height);
    for (std::size_t p = 0; made[i] && p < keep.pixels.size(); ++p)
      if (keep.pixels[p] == 0 || keep.pixels[p] == 255) made[i]->pixels[p] = keep.pixels[p];
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
  auto impl = std::make_unique<Impl>();
  impl->rig = rig;
  impl->options = options;
  impl->shared = *shared;
  impl->views.resize(rig.cameras.size());
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const CameraModel& m = rig.cameras[i].model;
    const double shrink =
        std::min(1.0, std::sqrt(options.working_pixels / (static_cast<double>(m.width) * m.height)));
    const auto side = [&](int px) { return std::max(3, static_cast<int>(std::lround(px * shrink))); };
    impl->views[i].w = side(m.width);
    impl->views[i].h = side(m.height);
    impl->sizes.emplace_back(impl->views[i].w, impl->views[i].h);
  }
  return ConsistentMatting(std::move(impl));
}

Eigen::Vector2i ConsistentMatting::working_size(int camera) const {
  return impl_->sizes.at(static_cast<std::size_t>(camera));
}

Result<void> ConsistentMatting::learn_backdrop(int camera, const std::vector<Image>& pictures) {
  View& v = impl_->views.at(static_cast<std::size_t>(camera));
  for (const Image& p : pictures)
    if (p.width != v.w || p.height != v.h || p.channels != 3)
      return fail(ErrorCode::InvalidArgument, text("a backdrop's pictures are RGB and ", v.w, "x", v.h));
  Result<matting::StillBackdrop> backdrop = matting::StillBackdrop::learn(pictures);
  if (!backdrop) return forward(backdrop);
  v.backdrop = std::move(*backdrop);
  return {};
}

void ConsistentMatting::forget() {
  impl_->colors.reset();
  impl_->grid.reset();
}

Result<ConsistentMattes> ConsistentMatting::matte(std::span<const Image> pictures,
                                                  std::span<const Image> said,
                                                  const std::function<bool()>& go_on) {
  Impl& m = *impl_;
  if (Result<void> ok = m.look(pictures, said); !ok) return forward(ok);
  const bool first = !m.colors;
  if (first) m.begin();
  ConsistentMattes out;
  for (double changed = 1;
       out.turns < (first ? m.options.turns : m.options.later_turns) && changed > kSettled;) {
    if (go_on && !go_on()) return fail(ErrorCode::Cancelled, "stopped while the views were made consistent");
    if (first || out.turns > 0) m.learn(first && out.turns == 0 ? kFirstNovelty : kNovelty);
    m.weigh_colors();
    m.ask_others();
    changed = m.cut();
    if (++out.turns <= kGridTurns && first) m.close_in();
  }
  m.learn(kNovelty);
  m.follow();
  std::vector<ViewEvidence> evidence;
  for (const View& v : m.views) evidence.push_back({v.there() ? v.label : Image(), v.odds, v.others});
  judge(m.rig, m.shared, evidence, out);
  if (Result<std::vector<Image>> mattes = m.finish(pictures, said); mattes)
    out.mattes = std::move(*mattes);
  else
    return forward(mattes);
  return out;
}

}  // namespace floatstage::pipeline
