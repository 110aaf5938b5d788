#include "pipeline/exr_file.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfRgba.h>

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

Result<void> save_exr(const Image& image, const std::filesystem::path& file, ExrAlpha alpha,
                      const std::vector<ExrLayer>& layers) {
  FLOATSTAGE_CHECK(image.channels == 3 || image.channels == 4, "EXRs are RGB or RGBA");
  for (const ExrLayer& l : layers)
    FLOATSTAGE_CHECK(l.opacity.channels == 1 && l.opacity.width == image.width &&
                         l.opacity.height == image.height && l.name.find('.') == std::string::npos,
                     "a layer's opacity, of the picture's size, under a name without a dot");
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
    Imf::Header header(image.width, image.height, 1, {0, 0}, 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);
    Imf::FrameBuffer buffer;
    const auto add = [&](const std::string& name, half* first, std::size_t step) {
      header.channels().insert(name, Imf::Channel(Imf::HALF));
      buffer.insert(name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(first), step,
                                     step * static_cast<std::size_t>(image.width)));
    };
    add("R", &pixels[0].r, sizeof(Imf::Rgba));
    add("G", &pixels[0].g, sizeof(Imf::Rgba));
    add("B", &pixels[0].b, sizeof(Imf::Rgba));
    if (channels == 4) add("A", &pixels[0].a, sizeof(Imf::Rgba));
    std::vector<std::vector<half>> opacities;
    for (const ExrLayer& l : layers) {
      std::vector<half>& opacity = opacities.emplace_back();
      opacity.reserve(pixels.size());
      for (const std::uint8_t a : l.opacity.pixels) opacity.emplace_back(static_cast<float>(a) / 255);
    }
    for (std::size_t l = 0; l < layers.size(); ++l)
      add(layers[l].name + ".A", opacities[l].data(), sizeof(half));
    Imf::OutputFile out(temporary.c_str(), header, 1);
    out.setFrameBuffer(buffer);
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

std::vector<std::string> exr_channels(const std::filesystem::path& file) {
  std::vector<std::string> names;
  try {
    const Imf::InputFile exr(file.c_str());
    const Imf::ChannelList& channels = exr.header().channels();
    for (auto c = channels.begin(); c != channels.end(); ++c) names.emplace_back(c.name());
  } catch (const std::exception&) {
    names.clear();
  }
  return names;
}

}  // namespace floatstage::pipeline
