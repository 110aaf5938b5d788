#include <cmath>
#include <exception>
#include <filesystem>
#include <vector>

#include <ImfRgbaFile.h>

#include "core/claim.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/matte/export_layers.h"

namespace floatstage::pipeline {
namespace {

// sRGB's curve undone (IEC 61966-2-1).
float linear(std::uint8_t v) {
  const float s = static_cast<float>(v) / 255;
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

Result<void> save_exr(const Image& rgba, const std::filesystem::path& file) {
  FLOATSTAGE_CHECK(rgba.channels == 4, "EXR layers are RGBA");
  const Result<Claim> claim = claim_temporary_file(file, IfThere::Replace);
  if (!claim) return forward(claim);
  const std::filesystem::path temporary = temporary_name(file);
  std::error_code none;
  try {
    std::vector<Imf::Rgba> pixels(rgba.pixels.size() / 4);
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      const std::uint8_t* s = rgba.pixels.data() + 4 * p;
      pixels[p] = Imf::Rgba(linear(s[0]), linear(s[1]), linear(s[2]), static_cast<float>(s[3]) / 255);
    }
    Imf::RgbaOutputFile out(temporary.c_str(), rgba.width, rgba.height, Imf::WRITE_RGBA, 1, {0, 0}, 1,
                            Imf::INCREASING_Y, Imf::ZIP_COMPRESSION, 1);
    out.setFrameBuffer(pixels.data(), 1, static_cast<std::size_t>(rgba.width));
    out.writePixels(rgba.height);
  } catch (const std::exception& e) {
    std::filesystem::remove(temporary, none);
    return fail(ErrorCode::Io, text("cannot write ", file.string(), ": ", e.what()));
  }
  std::error_code error;
  std::filesystem::rename(temporary, file, error);
  if (error) return fail(ErrorCode::Io, text("cannot write ", file.string(), ": ", error.message()));
  return {};
}

}  // namespace floatstage::pipeline
