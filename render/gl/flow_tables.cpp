#include "render/gl/flow_tables.h"

#include <algorithm>

#include "core/check.h"

namespace floatstage::render {
namespace {

constexpr GLuint kBinding = 1;  // shaders/flow.glsl has the same

}  // namespace

void FlowTables::write(std::span<const WantedField> fields) {
  FLOATSTAGE_CHECK(fields.size() <= static_cast<std::size_t>(kMostFields), "too many fields for the GPU");
  Block block{};
  block.from.fill(-1);
  std::array<int, kMostPictures> count{};
  pictures_ = asked_ = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const int first = static_cast<int>(fields[i].pair.first),
              second = static_cast<int>(fields[i].pair.second);
    FLOATSTAGE_CHECK(std::max(first, second) < kMostPictures, "too many pictures for the GPU");
    pictures_ = std::max({pictures_, first + 1, second + 1});
    block.fields[i] = {first, second, fields[i].back, fields[i].asked ? 1 : 0};
    if (!fields[i].asked) continue;
    int& k = count[static_cast<std::size_t>(first)];
    FLOATSTAGE_CHECK(k < 8, "too many fields of one picture for the GPU");
    block.from[static_cast<std::size_t>(8 * first + k++)] = static_cast<int>(i);
    ++asked_;
  }
  fields_ = static_cast<int>(fields.size());
  from_one_ = *std::max_element(count.begin(), count.end());
  gl::upload(buffer_, capacity_, &block, sizeof block);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBinding, buffer_.id());
}

}  // namespace floatstage::render
