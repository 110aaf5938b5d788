#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace floatstage::apps {

/// Where a photograph stands in the window, and how large. Pure arithmetic.
class PictureFit {
 public:
  /// `most`: how far one may zoom, times the whole.
  PictureFit(int width, int height, double most = 64)
      : size_(width, height), middle_(size_ / 2), most_(most) {}

  /// The part of the window that is there for it, px.
  void set_area(double left, double top, double width, double height) {
    area_ = {left, top};
    extent_ = {std::max(1.0, width), std::max(1.0, height)};
  }
  double top() const { return area_.y(); }
  bool holds(double x, double y) const {
    return x >= area_.x() && y >= area_.y() && x < area_.x() + extent_.x() && y < area_.y() + extent_.y();
  }

  /// Window px a photograph px.
  double scale() const { return zoom_ * std::min(extent_.x() / size_.x(), extent_.y() / size_.y()); }
  Eigen::Vector2d to_photograph(double x, double y) const {
    return middle_ + (Eigen::Vector2d(x, y) - area_ - extent_ / 2) / scale();
  }
  Eigen::Vector2d to_window(const Eigen::Vector2d& p) const {
    return area_ + extent_ / 2 + (p - middle_) * scale();
  }

  /// The point under (x, y) stays there. The whole photograph is the smallest there is.
  void zoom(double x, double y, double factor) {
    const Eigen::Vector2d fixed = to_photograph(x, y);
    zoom_ = std::clamp(zoom_ * factor, 1.0, most_);
    middle_ += fixed - to_photograph(x, y);
    keep_inside();
  }
  void pan(double dx, double dy) {
    middle_ -= Eigen::Vector2d(dx, dy) / scale();
    keep_inside();
  }
  /// This point of the photograph comes into the middle, so many window px a photograph px.
  void look_at(const Eigen::Vector2d& p, double scale) {
    zoom_ = std::clamp(zoom_ * scale / this->scale(), 1.0, most_);
    middle_ = p;
    keep_inside();
  }
  const Eigen::Vector2d& middle() const { return middle_; }
  void whole() { zoom_ = 1, middle_ = size_ / 2; }

 private:
  void keep_inside() {
    middle_ =
        zoom_ <= 1 ? Eigen::Vector2d(size_ / 2) : middle_.cwiseMax(Eigen::Vector2d::Zero()).cwiseMin(size_);
  }

  Eigen::Vector2d size_, middle_, area_ = {0, 0}, extent_ = {1, 1};
  double zoom_ = 1, most_;
};

}  // namespace floatstage::apps
