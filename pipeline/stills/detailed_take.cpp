#include "pipeline/stills/detailed_take.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "calib/surface_colors.h"
#include "capture/derivation.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "core/text.h"
#include "detail/synthesis/enlarge.h"
#include "pipeline/derive/carried_files.h"
#include "pipeline/export/surface_sights.h"
#include "pipeline/recorded_take.h"
#include "pipeline/stills/enlarged_photo.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using detail::Provenance;

constexpr int kMostZoom = 16, kUsualZoom = 4;
constexpr double kMostPixels = 32e6;
constexpr std::size_t kMostNamed = 10;  // stills in an error
constexpr int kOutline =
    3;  // px of a photograph along the subject's outline, where no two cameras see the same
constexpr double kMostTurn = 75;  // degrees between cameras that details are carried between

// Straight from the homography.
StillMap direct_map(const StillPlace& place, const Image& photo, const Image& still) {
  StillMap map(photo.width, photo.height);
  const Eigen::Matrix3d still_from_photo = place.photo_from_still.inverse();
  for (int y = 0; y < photo.height; ++y)
    for (int x = 0; x < photo.width; ++x) {
      const Eigen::Vector3d p = still_from_photo * Eigen::Vector3d(x + 0.5, y + 0.5, 1);
      const Eigen::Vector2d at = p.hnormalized();
      if (p.z() * still_from_photo(2, 2) > 0 && at.x() >= 1 && at.y() >= 1 && at.x() <= still.width - 1 &&
          at.y() <= still.height - 1)
        map(x, y) = at.cast<float>();
    }
  return map;
}

CameraModel enlarged(CameraModel model, int by) {
  model.width *= by, model.height *= by;
  model.fx *= by, model.fy *= by, model.cx *= by, model.cy *= by, model.skew *= by;
  return model;
}

// The least in `by` pixels each way.
Image eroded(const Image& matte, int by) {
  const auto along = [by](const Image& from, bool rows) {
    Image to = from;
    for (int y = 0; y < from.height; ++y)
      for (int x = 0; x < from.width; ++x)
        for (int d = -by; d <= by; ++d) {
          const int i = rows ? x + d : x, j = rows ? y : y + d;
          if (i >= 0 && j >= 0 && i < from.width && j < from.height)
            *to.at(x, y) = std::min(*to.at(x, y), *from.at(i, j));
        }
    return to;
  };
  return matte.empty() ? matte : along(along(matte, true), false);
}

// Half of the picture, half of what says where it comes from.
Image painted(const Image& picture, const Image& provenance) {
  const Image colors = detail::provenance_picture(provenance);
  Image out = picture;
  for (std::size_t i = 0; i < out.pixels.size(); ++i)
    out.pixels[i] = static_cast<std::uint8_t>((out.pixels[i] + colors.pixels[i]) / 2);
  return out;
}

class Detailing {
 public:
  Detailing(capture::TakeReader& take, const DetailedTakeOptions& options, const fs::path& folder)
      : take_(take), options_(options), to_(folder) {}

  Result<DetailedTakeReport> run(capture::TakeCodec codec, std::vector<std::string> notes) {
    report_.notes = std::move(notes);
    SceneLoader loader(take_, /*suppress_spill=*/true);
    Result<StraightInstant> instant = load_straight_instant(take_, loader, options_.frame);
    if (!instant) return forward(instant);
    instant_ = *std::move(instant);
    inner_ = instant_;
    for (Image& matte : inner_.mattes) matte = eroded(matte, kOutline);
    if (Result<void> ok = find_stills(); !ok) return forward(ok);
    if (Result<void> ok = choose_zoom(); !ok) return forward(ok);
    if (Result<void> ok = carry_all(); !ok) return forward(ok);
    if (Result<void> ok = write(codec); !ok) return forward(ok);
    return std::move(report_);
  }

 private:
  struct Carrier {
    std::size_t camera;
    StillMap map;
  };

  Result<void> find_stills() {
    const fs::path scratch = to_.folder() / "scratch";
    if (Result<void> ok = make_folder(scratch); !ok) return ok;
    Result<PlacedStills> placed = place_stills(instant_, {.folder = options_.stills,
                                                          .scratch = scratch,
                                                          .threads = options_.threads,
                                                          .progress = options_.progress});
    std::error_code ignored;
    fs::remove_all(scratch, ignored);
    if (!placed) return forward(placed);
    placed_ = *std::move(placed);
    report_.refused = placed_.refused;
    if (!placed_.places.empty()) return {};
    std::string why;
    const std::size_t named = std::min(placed_.refused.size(), kMostNamed);
    for (std::size_t i = 0; i < named; ++i)
      why += text("\n  ", placed_.refused[i].name, ": ", placed_.refused[i].why);
    if (placed_.refused.size() > named) why += text("\n  and ", placed_.refused.size() - named, " others");
    return fail(ErrorCode::NotFound,
                text("no still in ", options_.stills.string(), " shows a part of a photograph of frame ",
                     options_.frame, "; is it of this performer and instant?", why));
  }

  Result<void> choose_zoom() {
    double closest = 1, pixels = 0;
    for (const StillPlace& p : placed_.places) closest = std::max(closest, p.zoom);
    for (const Image& picture : instant_.pictures)
      pixels = std::max(pixels, static_cast<double>(picture.width) * picture.height);
    const int allowed = std::max(1, static_cast<int>(std::sqrt(kMostPixels / pixels)));
    if (options_.zoom > allowed)
      return fail(ErrorCode::InvalidArgument, text("--zoom ", options_.zoom,
                                                   ": photographs would have more than 32 "
                                                   "million pixels; ",
                                                   allowed, " is the most"));
    zoom_ = options_.zoom > 0 ? options_.zoom
                              : std::min({static_cast<int>(std::ceil(closest)), kUsualZoom, allowed});
    return {};
  }

  Result<void> carry_all() {
    const std::size_t cameras = instant_.rig.cameras.size();
    for (const RigCamera& camera : instant_.rig.cameras) report_.cameras.push_back({camera.serial, 1, {}});
    // Closer ones replace what wider ones gave.
    std::vector<std::size_t> order(placed_.stills.size());
    for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return zoom_of(a) < zoom_of(b); });
    ProgressPart part(options_.progress, "details", order.size() * cameras);
    const SurfaceSights sights(inner_);
    for (const std::size_t still : order) {
      Result<std::vector<Carrier>> carriers = carry_directly(still, part);
      if (!carriers) return forward(carriers);
      for (std::size_t c = 0; c < cameras; ++c) {
        if (has_place(still, c)) continue;
        if (is_cancelled(options_.progress)) return cancelled_unwritten();
        if (Result<void> ok = carry_over(still, c, *carriers, sights); !ok) return ok;
        part.advance();
      }
    }
    return {};
  }

  // Enlarged when it is first asked for: of a dome's cameras few get details.
  EnlargedPhoto& photo_of(std::size_t camera) {
    return photos_
        .try_emplace(camera, inner_.pictures[camera], inner_.mattes[camera], zoom_, options_.threads)
        .first->second;
  }

  double zoom_of(std::size_t still) const {
    double zoom = 0;
    for (const StillPlace& p : placed_.places)
      if (p.still == still) zoom = std::max(zoom, p.zoom);
    return zoom;
  }
  bool has_place(std::size_t still, std::size_t camera) const {
    return std::any_of(placed_.places.begin(), placed_.places.end(),
                       [&](const StillPlace& p) { return p.still == still && p.camera == camera; });
  }

  Result<std::vector<Carrier>> carry_directly(std::size_t still, ProgressPart& part) {
    std::vector<Carrier> carriers;
    for (const StillPlace& place : placed_.places) {
      if (place.still != still) continue;
      if (is_cancelled(options_.progress)) return cancelled_unwritten();
      const Image& picture = placed_.stills[still].picture;
      Result<CarriedStill> carried =
          photo_of(place.camera)
              .carry(picture, place.zoom, direct_map(place, instant_.pictures[place.camera], picture),
                     Provenance::Real);
      if (!carried) return forward(carried);
      note(still, place.camera, true, place.zoom, *carried);
      if (carried->why_not.empty()) carriers.push_back({place.camera, std::move(carried->map)});
      part.advance();
    }
    return carriers;
  }

  // From the camera that looks at the subject most as this one does.
  Result<void> carry_over(std::size_t still, std::size_t camera, const std::vector<Carrier>& carriers,
                          const SurfaceSights& sights) {
    const Eigen::Vector3d middle = bounding_box(instant_.mesh).center().cast<double>();
    const auto towards = [&](std::size_t c) -> Eigen::Vector3d {
      return (instant_.rig.cameras[c].cam_from_world.center() - middle).normalized();
    };
    const Carrier* nearest = nullptr;
    double least = kMostTurn * M_PI / 180;
    for (const Carrier& carrier : carriers) {
      const double turn = std::acos(std::clamp(towards(camera).dot(towards(carrier.camera)), -1.0, 1.0));
      if (turn < least) least = turn, nearest = &carrier;
    }
    if (nearest == nullptr) return {};
    double zoom = 0;
    const StillMap map = map_over(*nearest, camera, sights, zoom);
    if (zoom == 0) return {};
    Result<CarriedStill> carried =
        photo_of(camera).carry(placed_.stills[still].picture, zoom, map, Provenance::Warped);
    if (!carried) return forward(carried);
    note(still, camera, false, zoom, *carried);
    return {};
  }

  // By way of the hull. `zoom`: mean, of the still's pixels in one of the photograph; 0: it shows nothing of
  // it.
  StillMap map_over(const Carrier& from, std::size_t camera, const SurfaceSights& sights,
                    double& zoom) const {
    const RigCamera& to = instant_.rig.cameras[camera];
    const std::vector<float> depth = calib::depth_map(instant_.mesh, to);
    const Rigid3 world_from_cam = to.cam_from_world.inverse();
    StillMap map(to.model.width, to.model.height);
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) {
        const auto z = static_cast<double>(depth[static_cast<std::size_t>(y) * map.width + x]);
        if (!std::isfinite(z)) continue;
        const auto ray = unproject(to.model, {x + 0.5, y + 0.5});
        if (!ray) continue;
        const std::optional<Eigen::Vector2d> seen = sights.see(from.camera, world_from_cam * (z * *ray));
        if (seen) map(x, y) = from.map.between(seen->x(), seen->y());
      }
    double area = 0, count = 0;
    for (int y = 0; y + 1 < map.height; ++y)
      for (int x = 0; x + 1 < map.width; ++x) {
        const Eigen::Vector2f right = map(x + 1, y) - map(x, y), down = map(x, y + 1) - map(x, y);
        const double pixels = std::abs(static_cast<double>(right.x() * down.y() - right.y() * down.x()));
        if (std::isfinite(pixels)) area += pixels, count += 1;
      }
    zoom = count > 0 ? std::sqrt(area / count) : 0;
    return map;
  }

  void note(std::size_t still, std::size_t camera, bool direct, double zoom, const CarriedStill& carried) {
    DetailedCamera& of = report_.cameras[camera];
    of.stills.push_back(
        {placed_.stills[still].name, direct, zoom, carried.used, carried.moved, carried.why_not});
    if (carried.why_not.empty()) of.zoom = zoom_;
  }

  Result<void> write(capture::TakeCodec codec) {
    Rig rig = instant_.rig;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      rig.cameras[c].model = enlarged(rig.cameras[c].model, report_.cameras[c].zoom);
    capture::TakeWriterOptions take;
    take.codec = codec;
    take.frame_rate = take_.manifest().frame_rate;
    take.label = options_.label.empty() ? take_.manifest().label : options_.label;
    take.created = take_.manifest().created;
    take.is_claimed = true;
    Result<std::unique_ptr<capture::TakeWriter>> writer =
        capture::TakeWriter::create(to_.folder(), rig, take);
    if (!writer) return forward(writer);
    for (const fs::path& folder : {to_.mattes(), to_.meshes(), to_.folder() / "detail"})
      if (Result<void> ok = make_folder(folder); !ok) return ok;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      if (Result<void> ok = write_camera(c, **writer); !ok) return ok;
    if (Result<void> ok = save_ply(instant_.mesh, to_.mesh(0)); !ok) return ok;
    if (Result<void> ok = (*writer)->finish(); !ok) return ok;
    if (Result<void> ok = seal_take(to_.folder(), options_.progress); !ok) return ok;
    return capture::save_derivation(
        {take_.layout().folder().string(),
         text("add-detail ", options_.stills.string(), " of frame ", options_.frame)},
        to_.folder());
  }

  Result<void> write_camera(std::size_t c, capture::TakeWriter& writer) {
    const DetailedCamera& of = report_.cameras[c];
    const int index = camera_index(take_.rig(), of.serial);
    const Result<Frame> taken = take_.frame(index, options_.frame);
    if (!taken) return forward(taken);
    FrameInfo info = taken->info;
    info.camera = static_cast<int>(c);
    info.sequence = 0;
    Image picture = instant_.pictures[c];
    if (of.zoom > 1) {
      const EnlargedPhoto& photo = photo_of(c);
      picture = photo.picture();
      const fs::path file = to_.folder() / "detail" / (of.serial + ".png");
      if (Result<void> ok = save_png(detail::provenance_picture(photo.provenance()), file); !ok) return ok;
      if (options_.paint_provenance) picture = painted(picture, photo.provenance());
    }
    if (Result<void> ok = writer.write(make_frame(info, picture)); !ok) return ok;
    if (instant_.mattes[c].empty()) return {};
    const fs::path file = to_.matte(of.serial, 0);
    if (Result<void> ok = make_folder(file.parent_path()); !ok) return ok;
    return save_png(enlarged_picture(instant_.mattes[c], of.zoom, options_.threads), file);
  }

  capture::TakeReader& take_;
  const DetailedTakeOptions& options_;
  const TakeLayout to_;
  StraightInstant instant_, inner_;  // inner_: its mattes end before the outlines
  PlacedStills placed_;
  int zoom_ = 1;
  std::map<std::size_t, EnlargedPhoto> photos_;  // by camera
  DetailedTakeReport report_;
};

}  // namespace

Result<DetailedTakeReport> add_detail(const DetailedTakeOptions& options) {
  if (options.zoom < 0 || options.zoom > kMostZoom)
    return fail(ErrorCode::InvalidArgument,
                text("--zoom ", options.zoom, " is not between 1 and ", kMostZoom));
  std::vector<std::unique_ptr<capture::TakeReader>> takes;
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  takes.push_back(std::move(*opened));
  Result<UnfinishedFolder> take = UnfinishedFolder::begin(options.out);
  if (!take) return forward(take);
  std::vector<std::string> notes;
  const capture::TakeCodec codec = lossless_codec(takes, notes);
  Result<DetailedTakeReport> report =
      Detailing(*takes.front(), options, take->folder()).run(codec, std::move(notes));
  if (!report) return report;
  if (const auto opens = capture::TakeReader::open(take->folder()); !opens) return forward(opens);
  if (Result<void> ok = take->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
