#include "render/gl/unseen.h"

#include "render/gl/projection.h"
#include "render/seen_pixels.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

constexpr GLuint kSeenBinding = 3;  // shaders/unseen_known.comp has the same

}  // namespace

Result<Unseen> Unseen::create() {
  Unseen made;
  Result<gl::Kernel> known = gl::Kernel::create("unseen_known.comp", {"window.glsl", "synchronize.glsl"}),
                     fill = gl::Kernel::create("unseen.comp", {"view.glsl", "picture.glsl", "fill.glsl"});
  Result<gl::PullPush> around = gl::PullPush::create();
  if (!known) return forward(known);
  if (!fill) return forward(fill);
  if (!around) return forward(around);
  made.known_ = std::move(*known);
  made.fill_ = std::move(*fill);
  made.around_ = std::move(*around);
  made.seen_ = gl::Buffer::create();
  glNamedBufferStorage(made.seen_.id(), sizeof(SeenPixels), nullptr, 0);
  return made;
}

void Unseen::run(const Projection& projection, ViewTarget& target) {
  StageTimes::enter("unseen");
  const Window& w = projection.window();
  const int margin = projection.margin(), width = w.width - 2 * margin, height = w.height - 2 * margin;
  const gl::Texture& drawn = target.begin_again();
  const gl::Texture& known = around_->begin(width, height, 2, true);
  known_.set(0, w.x, w.y).set(1, width, height).set(2, margin);
  glClearNamedBufferData(seen_.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kSeenBinding, seen_.id());
  known_.over(width, height, {&projection.visibility(), &drawn}, {&known});
  const gl::PullPush::Surroundings around = around_->surroundings();
  fill_.set(1, around.width, around.height).set(2, margin);
  projection.draw(fill_, {&projection.surface(), &known, around.texture, &drawn, around.all}, target);
}

}  // namespace floatstage::render
