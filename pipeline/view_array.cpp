#include "pipeline/view_array.h"

#include <cstring>

#include "core/check.h"

namespace floatstage::pipeline {

int rows_of(const ViewArray& array) { return array.views > 3 ? 2 : 1; }

int columns_of(const ViewArray& array) { return (array.views + rows_of(array) - 1) / rows_of(array); }

std::vector<View> views_of(const View& middle, const ViewArray& array, double distance) {
  FLOATSTAGE_CHECK(array.views >= 1 && array.views <= kMostViews, "a view array of so many views");
  std::vector<View> views;
  for (int i = 0; i < array.views; ++i) {
    const double right = (i - 0.5 * (array.views - 1)) * array.baseline;
    View view = middle;
    view.view_from_world.translation.x() -= right;
    view.model.cx += view.model.fx * right / distance;
    views.push_back(view);
  }
  return views;
}

Image tiled(const std::vector<Image>& pictures, const ViewArray& array) {
  const Image& first = pictures.front();
  const int columns = columns_of(array);
  Image all(first.width * columns, first.height * rows_of(array), first.channels);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const int left = static_cast<int>(i) % columns * first.width;
    const int top = static_cast<int>(i) / columns * first.height;
    for (int y = 0; y < first.height; ++y)
      std::memcpy(all.at(left, top + y), pictures[i].at(0, y),
                  static_cast<std::size_t>(first.width) * static_cast<std::size_t>(first.channels));
  }
  return all;
}

}  // namespace floatstage::pipeline
