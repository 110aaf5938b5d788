#include "pipeline/import/matte_files.h"

#include <algorithm>

#include "core/png.h"
#include "core/text.h"

namespace floatstage::pipeline {

Result<Image> matte_from_picture(const Image& picture) {
  Image matte(picture.width, picture.height, 1);
  const int channels = picture.channels;
  const bool has_alpha = channels == 2 || channels == 4;
  for (std::size_t i = 0; i < matte.pixels.size(); ++i) {
    const std::uint8_t* p = picture.pixels.data() + i * static_cast<std::size_t>(channels);
    if (channels == 3 && (p[0] != p[1] || p[1] != p[2]))
      return fail(ErrorCode::BadData, "is a colour picture, not a matte; a matte is grey or has alpha");
    matte.pixels[i] = has_alpha ? p[channels - 1] : p[0];
  }
  if (!matte.pixels.empty() && *std::max_element(matte.pixels.begin(), matte.pixels.end()) == 1)
    for (std::uint8_t& a : matte.pixels) a = a == 1 ? 255 : 0;
  return matte;
}

Result<MatteFiles> MatteFiles::find(const std::filesystem::path& folder, const calib::ForeignRig& foreign,
                                    const FrameRange& range) {
  Result<MediaSearch> search = find_media(folder, foreign);
  if (!search) return forward(search);
  MatteFiles files;
  for (std::size_t i = 0; i < search->cameras.size(); ++i)
    if (search->cameras[i].stills.empty()) files.without_.push_back(foreign.rig.cameras[i].serial);
  if (files.without_.size() == search->cameras.size())
    return fail(ErrorCode::NotFound,
                text(folder.string(),
                     ": there is no matte for any camera; they are named as the pictures "
                     "are; add them, or leave --mattes out and key the pictures"));
  files.cameras_ = std::move(search->cameras);
  files.range_ = range;
  return files;
}

Result<void> make_matte_folder(const TakeLayout& take, const std::string& serial) {
  std::error_code error;
  std::filesystem::create_directories(take.matte(serial, 0).parent_path(), error);
  if (!error) return {};
  return fail(ErrorCode::Io, text("cannot make a folder in ", take.mattes().string(), ": ", error.message()));
}

Result<void> MatteFiles::save(std::size_t camera, const RigCamera& rig_camera, int count,
                              const std::filesystem::path& take) const {
  const TakeLayout layout(take);
  const std::vector<std::filesystem::path>& stills = cameras_[camera].stills;
  if (stills.empty()) return {};
  if (Result<void> ok = make_matte_folder(layout, rig_camera.serial); !ok) return ok;
  const std::size_t first = stills.size() == 1 ? 0 : static_cast<std::size_t>(range_.first);
  for (int frame = 0; frame < count; ++frame) {
    const std::size_t at = first + static_cast<std::size_t>(frame * range_.step);
    if (at >= stills.size())
      return fail(ErrorCode::NotFound,
                  text(stills.back().parent_path().string(), ": camera '", rig_camera.serial, "' has ",
                       stills.size(), " mattes, but its picture ", at, " needs one too"));
    const Result<Image> picture = load_png(stills[at]);
    if (!picture) return forward(picture);
    const Result<Image> matte = matte_from_picture(*picture);
    if (!matte) return fail(matte.error().code, text(stills[at].string(), ": ", matte.error().message));
    if (matte->width != rig_camera.model.width || matte->height != rig_camera.model.height)
      return fail(ErrorCode::BadData, text(stills[at].string(), ": the matte is ", matte->width, "x",
                                           matte->height, ", but the pictures of camera '", rig_camera.serial,
                                           "' are ", rig_camera.model.width, "x", rig_camera.model.height));
    if (Result<void> ok = save_png(*matte, layout.matte(rig_camera.serial, frame)); !ok) return ok;
  }
  return {};
}

}  // namespace floatstage::pipeline
