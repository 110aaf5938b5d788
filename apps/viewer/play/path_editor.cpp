#include "apps/viewer/play/path_editor.h"

#include <algorithm>
#include <cmath>

namespace floatstage::apps {

void PathEditor::put(pipeline::PathKey key, double time) {
  constexpr double kSame = 1e-3;
  key.time = time;
  std::vector<pipeline::PathKey>& keys = path_.keys;
  const auto after = std::find_if(keys.begin(), keys.end(),
                                  [&](const pipeline::PathKey& k) { return k.time > time - kSame; });
  if (after != keys.end() && std::abs(after->time - time) <= kSame)
    *after = key;
  else
    keys.insert(after, key);
}

void PathEditor::append(pipeline::PathKey key, double step) {
  put(key, empty() ? 0 : path_.keys.back().time + step);
}

void PathEditor::remove(std::size_t index) {
  path_.keys.erase(path_.keys.begin() + static_cast<std::ptrdiff_t>(index));
}

}  // namespace floatstage::apps
