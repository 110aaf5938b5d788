#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "render/camera_choice.h"
#include "render/cpu/covered.h"
#include "render/cpu/photo_kernels.h"
#include "render/cpu/photo_levels.h"
#include "render/cpu/scene_maps.h"
#include "render/interruption.h"
#include "render/projected_images.h"
#include "render/renderer.h"
#include "render/view_window.h"

namespace floatstage::render::cpu {

/// Memory for one row's work, handed out in pieces and taken back all at once. One thread at a time.
class RowMemory {
 public:
  void begin(std::size_t floats) {
    if (memory_.size() < floats) memory_.resize(floats);
    used_ = 0;
  }
  float* floats(std::size_t count);
  std::int32_t* ints(std::size_t count) { return reinterpret_cast<std::int32_t*>(floats(count)); }
  std::size_t used() const { return used_; }
  void take_back(std::size_t used) { used_ = used; }  ///< all that was handed out since used() said this

 private:
  std::vector<float> memory_;
  std::size_t used_ = 0;
};

/// The view on the window's pixels.
ViewRays view_rays(const View& view, const Window& window);

/// The first half of every renderer: the proxy from the view, who sees what (depth maps, frame, matte), soft
/// visibility (Eq. 11.5), the cameras' weights, and the intermediate images I_i^v where they are wanted.
/// Planes have a value for each pixel of the window, lists one for each covered pixel (see Covered). Storage
/// only grows.
class Projection {
 public:
  struct Wanted {
    int margin = 0;           ///< px around the view
    bool one_camera = false;  ///< all weight to the best visible camera of each pixel
    bool images = false;
    bool levels = false;                    ///< photographs' pyramids, whatever the footprints are
    bool mattes = false;                    ///< what they say at the surface
    bool fill = true;                       ///< with images: RendererOptions::fill_hidden
    float unreached = 0;                    ///< opacity of what no picture of the list reaches
    const CameraChoice* cameras = nullptr;  ///< instead of those that the view would choose
  };
  /// Cancelled when the picture was given up.
  Result<void> run(const Scene& scene, const View& view, const RendererOptions& options,
                   const Wanted& wanted);
  /// Of the picture that run() began; what is asked of whoever may give it up.
  Interruption& interruption() { return interruption_; }

  const Window& window() const { return window_; }
  const CameraChoice& choice() const { return choice_; }
  const Covered& covered() const { return covered_; }
  const ViewRays& rays() const { return rays_; }
  const PhotoCamera& camera(std::size_t slot) const { return photos_[slot].photograph(); }
  const PhotoLevels& photo(std::size_t slot) const { return photos_[slot]; }
  /// List: the footprints of the view's pixels in a photograph; null where none needs its pyramid.
  const float* footprint(std::size_t slot) const {
    return minified_[slot] ? footprint_[slot].data() : nullptr;
  }
  /// Colours of a photograph for a row's pixels, as large as they cover it; as PhotoLevels::read().
  void read(std::size_t slot, const Covered::Row& row, const float* u, const float* v,
            const std::int32_t* wanted, float* rgba, RowMemory& memory) const {
    const float* area = footprint(slot);
    photos_[slot].read(sharp_, u, v, area != nullptr ? area + row.list : nullptr, wanted, row.count, rgba,
                       memory);
  }
  float tolerance() const { return tolerance_; }
  float radius() const { return radius_; }  ///< px: of soft visibility
  int margin() const { return margin_; }    ///< px of the window on each side, beyond what the proxy covers
  int threads() const { return threads_; }
  bool sharp() const { return sharp_; }

  const float* inverse_z() const { return inverse_z_.data(); }  ///< plane, 0 off the proxy
  const std::uint8_t* own() const { return own_.data(); }       ///< plane, with images: a bit an image
  const std::uint32_t* image(std::size_t i) const { return images_[i].data(); }    ///< plane: RGBA bytes
  const float* soft_plane(std::size_t i) const { return soft_planes_[i].data(); }  ///< plane, with images
  const std::uint8_t* visible() const { return visible_.data(); }                  ///< list: a bit a camera
  const float* angular(std::size_t slot) const { return angular_[slot].data(); }   ///< list
  const float* weight(std::size_t slot) const { return weight_[slot].data(); }     ///< list
  const float* soft(std::size_t slot) const { return soft_[slot].data(); }         ///< list
  /// Lists, where they are wanted: the mean and the largest of what mattes say of those cameras that look;
  /// where none does 1, and the largest of all whose pictures reach there.
  const float* matte() const { return matte_.data(); }
  const float* most_opaque() const { return most_opaque_.data(); }
  const ScreenMesh& on_screen() const { return raster_.seen(); }  ///< the proxy as the window shows it

  /// Calls body(y, memory) for every row with covered pixels, rows of a band in order on one thread; bands
  /// that are left when the picture is given up are left out.
  template <class Body>
  void for_rows(const Body& body) {
    parallel_for(bands_.size(), threads_, [&](std::size_t band) {
      if (interruption_.given_up()) return;
      for (int y = bands_[band].first; y < bands_[band].last; ++y) {
        if (covered_.rows[static_cast<std::size_t>(y)].count == 0) continue;
        memory_[band].begin(row_floats_);
        body(y, memory_[band]);
      }
    });
  }

  /// The triangles' normals at a row's pixels, in the world, towards the eye: lists of the row.
  void write_normals(int y, float* nx, float* ny, float* nz) const;

  /// The images for the flow: grey, and at 1/shrink of their size.
  void gray_images(int shrink, ProjectedImages& out);

 private:
  struct Band {
    int first, last;
  };
  void take_photographs(const Scene::Impl& scene, const View& view, bool levels);
  void reserve();
  void plan_bands();
  void see_row(int y, const Wanted& wanted, RowMemory& memory);
  void weigh_row(int y, const Wanted& wanted, RowMemory& memory);
  void measure_row(int y, RowMemory& memory);
  void soften_row(int y, RowMemory& memory);
  void fill_row(int y, RowMemory& memory);
  void show_hidden(int y, RowMemory& memory);
  std::size_t line(int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(window_.width);
  }

  Interruption interruption_;
  Window window_;
  CameraChoice choice_;
  Covered covered_;
  ViewRays rays_{};
  std::array<PhotoLevels, kMostListed> photos_{};
  std::array<bool, kMostListed> minified_{};
  const Mesh* mesh_ = nullptr;
  float tolerance_ = 0, radius_ = 0;
  bool sharp_ = true;
  int threads_ = 0;
  int margin_ = 0;

  ProxyRaster raster_;
  std::vector<float> inverse_z_;
  std::vector<std::uint32_t> triangle_;
  std::vector<std::uint8_t> hidden_, own_, visible_;
  std::array<std::vector<std::int16_t>, kMostListed> row_distances_;
  std::array<std::vector<std::uint8_t>, kMostListed> row_has_hidden_;
  std::array<std::vector<float>, kMostListed> angular_, weight_, soft_, soft_planes_, footprint_;
  std::vector<float> matte_, most_opaque_;
  std::array<std::vector<std::uint32_t>, kMostListed> images_;
  std::vector<Band> bands_;
  std::vector<RowMemory> memory_;
  std::size_t row_floats_ = 0;
};

}  // namespace floatstage::render::cpu
