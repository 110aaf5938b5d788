// Zipmaps by OpenGL: M. Eisemann, "Error-Concealed Image-Based Rendering", 5.2. Differs: layers of one array
// texture instead of texture units; passes are laid over one another by blending instead of reading
// coordinates that were written before; levels come from the processor (ADR 0275).

#include "render/zipmap/gl_zipmap.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/text.h"
#include "render/gl/gl_objects.h"
#include "render/zipmap/layer_cache.h"

namespace floatstage::render {
namespace {

using Eigen::Matrix3d;

constexpr std::size_t kRootTexel = 3, kTexel = 4;  // bytes: three layers of one, RGBA

struct ArrayKind {
  static GLuint create() {
    GLuint id = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
    return id;
  }
  static void destroy(GLuint id) { glDeleteTextures(1, &id); }
};

/// Mirrors Patch in shaders/zipmap.frag.
struct PatchBlock {
  std::array<std::array<float, 4>, 3> rows{};
  std::array<std::int32_t, 4> place{};
  std::array<float, 4> tint{};
};

// The levels of a texture of this size, and their bytes.
int levels_of(int width, int height) {
  int levels = 1;
  while ((std::max(width, height) >> levels) > 0) ++levels;
  return levels;
}
std::size_t bytes_of_levels(int width, int height, std::size_t texel) {
  std::size_t bytes = 0;
  for (int l = 0; l < levels_of(width, height); ++l)
    bytes += texel * static_cast<std::size_t>(std::max(1, width >> l)) *
             static_cast<std::size_t>(std::max(1, height >> l));
  return bytes;
}

void set_sampling(GLuint texture, GLint smaller) {
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, smaller);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

GLint limit(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

class Drawer : public GlZipmap {
 public:
  Drawer(std::shared_ptr<const Zipmap> zipmap, gl::Program program, int layers, int width, int height)
      : zipmap_(std::move(zipmap)),
        program_(std::move(program)),
        no_vertices_(gl::VertexArray::create()),
        framebuffer_(gl::Framebuffer::create()),
        root_(gl::Object<ArrayKind>::create()),
        layers_(gl::Object<ArrayKind>::create()),
        cache_(*zipmap_, layers) {
    load_root();
    make_layers(layers, width, height);
  }

  Result<DrawnZipmap> draw(const ZipmapView& view, const ZipmapDrawing& drawing) override {
    if (view.width <= 0 || view.height <= 0 || std::max(view.width, view.height) > limit(GL_MAX_TEXTURE_SIZE))
      return fail(ErrorCode::InvalidArgument,
                  text("a picture of ", view.width, "x", view.height, " px cannot be drawn"));
    begin(view, drawing);
    DrawnZipmap drawn;
    std::vector<std::vector<PatchNeed>> passes =
        cache_.passes(drawing.plain_from > 0 ? needs_of(*zipmap_, view) : std::vector<PatchNeed>());
    if (passes.empty()) passes.emplace_back();  // the root is drawn in any case
    const bool patient = passes.size() == 1 && drawing.most_loaded > 0;
    for (const std::vector<PatchNeed>& pass : passes) {
      for (const LayerLoad& load : cache_.load(
               pass, patient ? drawing.most_loaded : std::numeric_limits<std::size_t>::max(), drawn.waiting))
        drawn.loaded += copy(load);
      drawn.patches += draw_pass(pass, drawing.tints, drawn.passes++ == 0);
    }
    glDisable(GL_BLEND);
    return drawn;
  }

  unsigned texture() const override { return target_.id(); }
  Image read() const override {
    Image rgb(target_.width(), target_.height(), 3);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(target_.id(), 0, GL_RGB, GL_UNSIGNED_BYTE, static_cast<GLsizei>(rgb.pixels.size()),
                      rgb.pixels.data());
    return rgb;
  }
  std::size_t allocated() const override { return allocated_; }
  int layers() const override { return cache_.layers(); }
  const Zipmap& zipmap() const override { return *zipmap_; }

 private:
  // A layer each for red, green and blue: drivers store a texel of three bytes in four.
  void load_root() {
    const std::vector<Image>& levels = zipmap_->root().levels();
    glTextureStorage3D(root_.id(), static_cast<GLsizei>(levels.size()), GL_R8, levels[0].width,
                       levels[0].height, 3);
    set_sampling(root_.id(), GL_LINEAR_MIPMAP_LINEAR);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    std::vector<std::uint8_t> one;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const Image& level = levels[l];
      const auto channels = static_cast<std::size_t>(level.channels);
      one.resize(level.pixels.size() / channels);
      for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < one.size(); ++i)
          one[i] = level.pixels[channels * i + static_cast<std::size_t>(c)];
        glTextureSubImage3D(root_.id(), static_cast<GLint>(l), 0, 0, c, level.width, level.height, 1, GL_RED,
                            GL_UNSIGNED_BYTE, one.data());
      }
    }
    allocated_ = bytes_of_levels(levels[0].width, levels[0].height, kRootTexel);
  }

  void make_layers(int layers, int width, int height) {
    const int levels = levels_of(width, height), depth = std::max(1, layers);
    glTextureStorage3D(layers_.id(), levels, GL_RGBA8, width, height, depth);
    set_sampling(layers_.id(), GL_NEAREST_MIPMAP_NEAREST);
    allocated_ += static_cast<std::size_t>(depth) * bytes_of_levels(width, height, kTexel);
  }

  std::size_t copy(const LayerLoad& load) {
    const Image& level = zipmap_->pictures()[load.picture].levels()[load.level];
    glTextureSubImage3D(layers_.id(), static_cast<GLint>(load.level), 0, 0, load.layer, level.width,
                        level.height, 1, GL_RGBA, GL_UNSIGNED_BYTE, level.pixels.data());
    return level.pixels.size();
  }

  void begin(const ZipmapView& view, const ZipmapDrawing& drawing) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (target_.resize(GL_RGBA16F, GL_LINEAR, view.width, view.height))
      glNamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT0, target_.id(), 0);
    const Eigen::Matrix3f uv_from_pixel = view.uv_from_pixel.cast<float>();
    glProgramUniformMatrix3fv(program_.id(), 0, 1, GL_FALSE, uv_from_pixel.data());
    glProgramUniform1i(program_.id(), 2, static_cast<int>(view.wrap));
    const ZipmapTints& tints = drawing.tints;
    glProgramUniform4f(program_.id(), 4, tints.root.x(), tints.root.y(), tints.root.z(), tints.strength);
    glProgramUniform3f(program_.id(), 5, tints.rim.x(), tints.rim.y(), tints.rim.z());
    glProgramUniform1i(program_.id(), 6, drawing.plain_from);
    glBindTextureUnit(0, root_.id());
    glBindTextureUnit(1, layers_.id());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, view.width, view.height);
    for (const GLenum off : {GL_DEPTH_TEST, GL_CULL_FACE, GL_SCISSOR_TEST}) glDisable(off);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);  // colours come multiplied by their opacity
    glUseProgram(program_.id());
    glBindVertexArray(no_vertices_.id());
  }

  // How many patches it drew: of those whose pictures are not there yet, none.
  int draw_pass(const std::vector<PatchNeed>& pass, const ZipmapTints& tints, bool with_root) {
    std::vector<PatchBlock> blocks;
    for (const PatchNeed& need : pass) {
      const Zipmap::Patch& patch = zipmap_->patches()[need.patch];
      const std::vector<Image>& levels = zipmap_->pictures()[patch.picture].levels();
      const std::size_t finest = cache_.finest(patch.picture);
      if (finest == levels.size()) continue;
      PatchBlock block;
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
          block.rows[r][c] = static_cast<float>(
              patch.patch_from_root(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)));
      block.place = {cache_.layer_of(patch.picture), levels[0].width, levels[0].height,
                     static_cast<std::int32_t>(finest)};
      const Eigen::Vector3f tint =
          need.patch < tints.patches.size() ? tints.patches[need.patch] : Eigen::Vector3f(0, 0, 0);
      block.tint = {tint.x(), tint.y(), tint.z(), static_cast<float>(levels.size() - 1)};
      blocks.push_back(block);
    }
    const auto count = static_cast<GLint>(blocks.size());
    if (blocks.empty()) blocks.emplace_back();  // a buffer has a size
    gl::upload(buffer_, capacity_, blocks.data(), blocks.size() * sizeof(PatchBlock));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer_.id());
    glProgramUniform2i(program_.id(), 1, 0, count);
    glProgramUniform1i(program_.id(), 3, with_root ? 1 : 0);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return count;
  }

  std::shared_ptr<const Zipmap> zipmap_;
  gl::Program program_;
  gl::VertexArray no_vertices_;
  gl::Framebuffer framebuffer_;
  gl::Object<ArrayKind> root_;
  gl::Object<ArrayKind> layers_;
  gl::Texture target_;
  gl::Buffer buffer_;
  std::size_t capacity_ = 0, allocated_ = 0;
  LayerCache cache_;
};

}  // namespace

Result<std::unique_ptr<GlZipmap>> GlZipmap::make(std::shared_ptr<const Zipmap> zipmap,
                                                 const GlZipmapOptions& options) {
  const Image& root = zipmap->root().levels()[0];
  int width = 1, height = 1;
  for (const MipPyramid& picture : zipmap->pictures()) {
    width = std::max(width, picture.levels()[0].width);
    height = std::max(height, picture.levels()[0].height);
  }
  const int most = limit(GL_MAX_TEXTURE_SIZE);
  if (std::max({root.width, root.height, width, height}) > most)
    return fail(ErrorCode::InvalidArgument,
                text("a zipmap of ", std::max(root.width, width), "x", std::max(root.height, height),
                     " px: this OpenGL driver draws ", most, " px a side; make its photographs smaller"));
  const std::size_t needed = bytes_of_levels(root.width, root.height, kRootTexel),
                    layer = bytes_of_levels(width, height, kTexel);
  const std::size_t pictures = zipmap->pictures().size();
  std::size_t layers = std::min(pictures, static_cast<std::size_t>(limit(GL_MAX_ARRAY_TEXTURE_LAYERS)));
  if (options.most_layers > 0) layers = std::min(layers, static_cast<std::size_t>(options.most_layers));
  if (needed + (pictures > 0 ? layer : 0) > options.budget)
    return fail(ErrorCode::InvalidArgument,
                text("a zipmap's root and one of its pictures take ", (needed + layer) >> 20,
                     " MiB of video memory, and ", options.budget >> 20, " are allowed; allow more"));
  layers = std::min(layers, (options.budget - needed) / layer);
  Result<gl::Program> program = gl::make_program("fullscreen.vert", "zipmap.frag");
  if (!program) return forward(program);
  return std::unique_ptr<GlZipmap>(std::make_unique<Drawer>(std::move(zipmap), std::move(*program),
                                                            static_cast<int>(layers), width, height));
}

}  // namespace floatstage::render
