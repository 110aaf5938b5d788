#include "apps/viewer/play/shown_texture.h"

#include <epoxy/gl.h>

namespace floatstage::apps {

ShownTexture::~ShownTexture() {
  if (id_ != 0) glDeleteTextures(1, &id_);
}

void ShownTexture::show(const Image& picture) {
  if (id_ == 0 || width_ != picture.width || height_ != picture.height) {
    if (id_ != 0) glDeleteTextures(1, &id_);
    glCreateTextures(GL_TEXTURE_2D, 1, &id_);
    glTextureStorage2D(id_, 1, GL_RGBA8, picture.width, picture.height);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTextureParameteri(id_, filter, GL_LINEAR);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
      glTextureParameteri(id_, wrap, GL_CLAMP_TO_EDGE);
    width_ = picture.width;
    height_ = picture.height;
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(id_, 0, 0, 0, width_, height_, picture.channels == 3 ? GL_RGB : GL_RGBA,
                      GL_UNSIGNED_BYTE, picture.pixels.data());
}

}  // namespace floatstage::apps
