#include "render/gl/pull_push.h"

#include <algorithm>

namespace floatstage::render::gl {
namespace {

constexpr int kGroup = 16;  // px: local size of the kernels

}  // namespace

Result<PullPush> PullPush::create() {
  PullPush made;
  Result<Kernel> pull = Kernel::create("fill_pull.comp", {}),
                 push = Kernel::create("fill_push.comp", {"fill.glsl"});
  if (!pull) return forward(pull);
  if (!push) return forward(push);
  made.pull_ = std::move(*pull);
  made.push_ = std::move(*push);
  return made;
}

const Texture& PullPush::begin(int width, int height, int layers, bool half) {
  layers_ = layers;
  for (count_ = 0;; width = (width + 1) / 2, height = (height + 1) / 2) {
    if (levels_.size() <= count_) levels_.emplace_back();
    Level& level = levels_[count_];
    level.width = width;
    level.height = height;
    level.known.reserve(half ? GL_RGBA16F : GL_RGBA32F, GL_NEAREST, width, height, layers);
    if (count_++ > 0) level.whole.reserve(half ? GL_RG16F : GL_RG32F, GL_NEAREST, width, height, layers);
    if (width == 1 && height == 1) break;
  }
  return levels_.front().known;
}

void PullPush::run(Kernel& kernel, std::size_t level, Kernel::Textures read, const Texture& written) {
  const Level& l = levels_[level];
  kernel.set(0, l.width, l.height);
  kernel.run(read, {&written}, groups_over(l.width, kGroup), groups_over(l.height, kGroup), layers_,
             static_cast<std::size_t>(l.width) * static_cast<std::size_t>(l.height) *
                 static_cast<std::size_t>(layers_));
}

PullPush::Surroundings PullPush::surroundings() {
  for (std::size_t l = 1; l < count_; ++l) {
    const Level& fine = levels_[l - 1];
    pull_.set(1, fine.width, fine.height);
    run(pull_, l, {&fine.known}, levels_[l].known);
  }
  // The coarsest pixel is all there is: it is its own surroundings.
  const Level* coarse = &levels_[count_ - 1];
  const Texture* around = &coarse->known;
  for (std::size_t l = count_ - 1; l-- > 1;) {
    push_.set(1, coarse->width, coarse->height);
    run(push_, l, {&levels_[l].known, around}, levels_[l].whole);
    coarse = &levels_[l];
    around = &coarse->whole;
  }
  return {around, coarse->width, coarse->height, &levels_[count_ - 1].known};
}

}  // namespace floatstage::render::gl
