#include "pipeline/exr_file.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <vector>

#include <ImfRgbaFile.h>

#include "core/claim.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

// sRGB's curve undone (IEC 61966-2-1).
float linear(std::uint8_t v) {
  const float s = static_cast<float>(v) / 255;
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

Result<void> save_exr(const Image& image, const std::filesystem::path& file, ExrAlpha alpha) {
  FLOATSTAGE_CHECK(image.channels == 3 || image.channels == 4, "EXRs are RGB or RGBA");
  const Result<Claim> claim = claim_temporary_file(file, IfThere::Replace);
  if (!claim) return forward(claim);
  const std::filesystem::path temporary = temporary_name(file);
  std::error_code none;
  try {
    const auto channels = static_cast<std::size_t>(image.channels);
    std::vector<Imf::Rgba> pixels(image.pixels.size() / channels);
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      const std::uint8_t* s = image.pixels.data() + channels * p;
      const float opacity = channels == 4 ? static_cast<float>(s[3]) / 255 : 1;
      const float scale = alpha == ExrAlpha::Associated ? opacity : 1;
      pixels[p] = Imf::Rgba(scale * linear(s[0]), scale * linear(s[1]), scale * linear(s[2]), opacity);
    }
    Imf::RgbaOutputFile out(temporary.c_str(), image.width, image.height,
                            channels == 4 ? Imf::WRITE_RGBA : Imf::WRITE_RGB, 1, {0, 0}, 1, Imf::INCREASING_Y,
                            Imf::ZIP_COMPRESSION, 1);
    out.setFrameBuffer(pixels.data(), 1, static_cast<std::size_t>(image.width));
    out.writePixels(image.height);
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
