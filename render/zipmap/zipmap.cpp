// Zipmaps: M. Eisemann, "Error-Concealed Image-Based Rendering", chapter 5; levels of detail as in
// OpenGL 4.5, 8.14.1. Differs: matrices may be homographies, as the photo graph measures them; a patch lies
// on its own sides of its horizon only (ADR 0220).

#include "render/zipmap/zipmap.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "core/check.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector4f;

/// A level in floats.
struct Level {
  int width = 0, height = 0;
  std::vector<Vector4f> texels;
  Vector4f& at(int x, int y) { return texels[static_cast<std::size_t>(y) * width + x]; }
  const Vector4f& at(int x, int y) const { return texels[static_cast<std::size_t>(y) * width + x]; }
};

Level level_of(const Image& picture) {
  Level level{picture.width, picture.height, {}};
  level.texels.resize(static_cast<std::size_t>(picture.width) * picture.height);
  for (std::size_t i = 0; i < level.texels.size(); ++i)
    for (int c = 0; c < 4; ++c)
      level.texels[i][c] = c < picture.channels
                               ? picture.pixels[i * static_cast<std::size_t>(picture.channels) + c] / 255.0F
                               : 1;
  return level;
}

Image image_of(const Level& level, int channels) {
  Image image(level.width, level.height, channels);
  for (std::size_t i = 0; i < level.texels.size(); ++i)
    for (int c = 0; c < channels; ++c)
      image.pixels[static_cast<std::size_t>(channels) * i + static_cast<std::size_t>(c)] =
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(level.texels[i][c], 0.0F, 1.0F)));
  return image;
}

// What of `from` texels a texel of `to` covers: the first, and the weights of up to three.
struct Cover {
  int first = 0, count = 0;
  std::array<float, 3> weights{};
};

Cover cover(int texel, int from, int to) {
  const double begin = static_cast<double>(texel) * from / to,
               end = static_cast<double>(texel + 1) * from / to;
  Cover c{static_cast<int>(begin), 0, {}};
  for (int i = c.first; i < end - 1e-9 && c.count < 3; ++i)
    c.weights[static_cast<std::size_t>(c.count++)] = static_cast<float>(
        (std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i))) / (end - begin));
  return c;
}

Level halved(const Level& from) {
  Level to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
  to.texels.resize(static_cast<std::size_t>(to.width) * to.height);
  for (int y = 0; y < to.height; ++y) {
    const Cover rows = cover(y, from.height, to.height);
    for (int x = 0; x < to.width; ++x) {
      const Cover columns = cover(x, from.width, to.width);
      Vector4f plain = Vector4f::Zero(), opaque = Vector4f::Zero();
      for (int j = 0; j < rows.count; ++j)
        for (int i = 0; i < columns.count; ++i) {
          const Vector4f& t = from.at(columns.first + i, rows.first + j);
          const float w =
              rows.weights[static_cast<std::size_t>(j)] * columns.weights[static_cast<std::size_t>(i)];
          plain += w * t;
          opaque += w * t[3] * t;
        }
      // Where nothing is opaque the colour still counts: it lies beside texels that are.
      if (plain[3] > 0) plain.head<3>() = opaque.head<3>() / plain[3];
      to.at(x, y) = plain;
    }
  }
  return to;
}

void clear_border_of(Image& level) {
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x)
      if (x == 0 || y == 0 || x == level.width - 1 || y == level.height - 1) level.at(x, y)[3] = 0;
}

Vector4f bilinear(const Image& level, const Vector2d& uv) {
  const double x = uv.x() * level.width - 0.5, y = uv.y() * level.height - 0.5;
  const double left = std::floor(x), top = std::floor(y);
  const auto a = static_cast<float>(x - left), b = static_cast<float>(y - top);
  const auto at = [&](double u, double v) {
    const std::uint8_t* t = level.at(static_cast<int>(std::clamp(u, 0.0, level.width - 1.0)),
                                     static_cast<int>(std::clamp(v, 0.0, level.height - 1.0)));
    return Vector4f(Vector4f(t[0], t[1], t[2], level.channels == 4 ? t[3] : 255) / 255);
  };
  return (1 - b) * ((1 - a) * at(left, top) + a * at(left + 1, top)) +
         b * ((1 - a) * at(left, top + 1) + a * at(left + 1, top + 1));
}

}  // namespace

double wrapped(double x, Zipmap::Wrap wrap) {
  if (wrap == Zipmap::Wrap::Clamp) return std::clamp(x, 0.0, 1.0);
  if (wrap == Zipmap::Wrap::Repeat) return x - std::floor(x);
  const double t = std::fmod(std::abs(x), 2.0);
  return t < 1 ? t : 2 - t;
}

double level_of_detail(const MipPyramid& p, const Vector2d& du, const Vector2d& dv) {
  const Vector2d size(p.levels()[0].width, p.levels()[0].height);
  return std::log2(std::max({du.cwiseProduct(size).norm(), dv.cwiseProduct(size).norm(), 1e-12}));
}

Eigen::Matrix2d step_under(const Matrix3d& h, const Vector3d& p) {
  return (h.topLeftCorner<2, 2>() - p.hnormalized() * h.block<1, 2>(2, 0)) / p.z();
}

MipPyramid::MipPyramid(const Image& picture, bool clear_border) {
  FLOATSTAGE_CHECK(!picture.empty() && picture.channels >= 3, "a pyramid is made of an RGB or RGBA picture");
  Level level = level_of(picture);
  for (;; level = halved(level)) {
    levels_.push_back(image_of(level, clear_border ? 4 : picture.channels));
    if (clear_border) clear_border_of(levels_.back());
    if (level.width == 1 && level.height == 1) break;
  }
}

std::size_t MipPyramid::bytes() const {
  std::size_t sum = 0;
  for (const Image& level : levels_) sum += level.pixels.size();
  return sum;
}

Vector4f MipPyramid::sample(const Vector2d& uv, double lod) const {
  const double at = std::clamp(lod, 0.0, static_cast<double>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(at);
  const auto between = static_cast<float>(at - static_cast<double>(fine));
  const Vector4f near = bilinear(levels_[fine], uv);
  if (between == 0) return near;
  return (1 - between) * near + between * bilinear(levels_[fine + 1], uv);
}

Zipmap::Zipmap(MipPyramid root, std::vector<MipPyramid> pictures, std::vector<Patch> patches)
    : root_(std::move(root)), pictures_(std::move(pictures)), patches_(std::move(patches)) {}

Result<Zipmap> Zipmap::make(const Image& root, const std::vector<Image>& pictures,
                            std::vector<Patch> patches) {
  if (root.empty() || root.channels < 3)
    return fail(ErrorCode::InvalidArgument, "a zipmap's root is an RGB picture");
  std::vector<MipPyramid> pyramids;
  for (const Image& picture : pictures) {
    if (picture.empty() || picture.channels < 3)
      return fail(ErrorCode::InvalidArgument,
                  text("picture ", pyramids.size(), " of a zipmap is no RGB or RGBA picture"));
    pyramids.emplace_back(picture, true);
  }
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (patches[i].picture >= pictures.size())
      return fail(ErrorCode::InvalidArgument,
                  text("patch ", i, " of a zipmap has a picture that there is not"));
    const Matrix3d& m = patches[i].patch_from_root;
    if (!m.allFinite() || !(std::abs(m.determinant()) > 1e-12))
      return fail(ErrorCode::InvalidArgument,
                  text("patch ", i, " of a zipmap has a matrix without an inverse"));
  }
  return Zipmap(MipPyramid(root, false), std::move(pyramids), std::move(patches));
}

Vector3f Zipmap::shade_over(Vector3f color, const Vector2d& uv, const Vector2d& du, const Vector2d& dv,
                            std::size_t first, std::size_t last, Wrap wrap) const {
  const Vector2d inside(wrapped(uv.x(), wrap), wrapped(uv.y(), wrap));
  for (std::size_t i = first; i < last; ++i) {
    const Matrix3d& m = patches_[i].patch_from_root;
    const Vector3d p = m * inside.homogeneous();
    if (!(p.z() > kHorizon)) continue;
    const Vector2d at = p.hnormalized();
    if (at.x() < 0 || at.y() < 0 || at.x() > 1 || at.y() > 1) continue;
    const Eigen::Matrix2d j = step_under(m, p);
    const MipPyramid& picture = pictures_[patches_[i].picture];
    const Vector4f c = picture.sample(at, level_of_detail(picture, j * du, j * dv));
    color += c[3] * (c.head<3>() - color);
  }
  return color;
}

Vector3f Zipmap::shade(const Vector2d& uv, const Vector2d& du, const Vector2d& dv, Wrap wrap) const {
  const Vector2d inside(wrapped(uv.x(), wrap), wrapped(uv.y(), wrap));
  const Vector3f under = root_.sample(inside, level_of_detail(root_, du, dv)).head<3>();
  return shade_over(under, uv, du, dv, 0, patches_.size(), wrap);
}

Image Zipmap::draw(const Matrix3d& uv_from_pixel, int width, int height, Wrap wrap, int threads) const {
  Image out(width, height, 3);
  parallel_for(static_cast<std::size_t>(height), threads, [&](std::size_t row) {
    for (int x = 0; x < width; ++x) {
      const Vector3d p = uv_from_pixel * Vector3d(x + 0.5, static_cast<double>(row) + 0.5, 1);
      if (!(p.z() > kHorizon)) continue;
      const Eigen::Matrix2d j = step_under(uv_from_pixel, p);
      const Vector3f c = shade(p.hnormalized(), j.col(0), j.col(1), wrap);
      for (int k = 0; k < 3; ++k)
        out.at(x, static_cast<int>(row))[k] =
            static_cast<std::uint8_t>(std::lround(255 * std::clamp(c[k], 0.0F, 1.0F)));
    }
  });
  return out;
}

std::size_t Zipmap::bytes() const {
  std::size_t sum = root_.bytes();
  for (const MipPyramid& picture : pictures_) sum += picture.bytes();
  return sum;
}

double Zipmap::finest() const {
  double most = 1;
  const Image& root = root_.levels()[0];
  for (const Patch& patch : patches_) {
    const Image& picture = pictures_[patch.picture].levels()[0];
    const Vector3d middle = patch.patch_from_root.inverse() * Vector3d(0.5, 0.5, 1);
    const Vector3d p = patch.patch_from_root * middle.hnormalized().homogeneous();
    const double area = std::abs(step_under(patch.patch_from_root, p).determinant()) * picture.width *
                        picture.height / (static_cast<double>(root.width) * root.height);
    most = std::max(most, std::sqrt(area));
  }
  return most;
}

double Zipmap::bytes_when_flat() const {
  const Image& root = root_.levels()[0];
  return 4.0 * root.width * root.height * finest() * finest() * 4 / 3;
}

}  // namespace floatstage::render
