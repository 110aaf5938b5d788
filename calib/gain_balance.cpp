// Median polish (Tukey, Exploratory Data Analysis, 1977, ch. 11) of the table points × cameras of log
// colours: a colour a point, a gain a camera. Differs: a point's colour is the mean of what cameras see of
// it, which a few decide well.
#include "calib/gain_balance.h"

#include <array>
#include <cmath>
#include <map>

#include "core/statistics.h"

namespace floatstage::calib {
namespace {

constexpr int kRounds = 60;        // cameras that share points with their neighbours only agree slowly
constexpr int kLeastPoints = 100;  // for a median right to about a tenth of the spread of single points
constexpr double kDark = 0.04, kBright = 0.97;  // black level, noise and clipping change ratios beyond these

struct Sight {
  std::size_t camera;
  Eigen::Vector3d log_color;
};

std::vector<std::vector<Sight>> shared_points(std::span<const ColorSample> samples) {
  std::map<int, std::vector<Sight>> points;
  for (const ColorSample& s : samples)
    if (s.seen.minCoeff() >= kDark && s.seen.maxCoeff() <= kBright)
      points[s.point].push_back({static_cast<std::size_t>(s.camera), s.seen.array().log()});
  std::vector<std::vector<Sight>> shared;
  for (auto& [point, sights] : points)
    if (sights.size() > 1) shared.push_back(std::move(sights));
  return shared;
}

}  // namespace

GainBalance balance_gains(std::span<const ColorSample> samples, std::size_t cameras) {
  const std::vector<std::vector<Sight>> points = shared_points(samples);
  GainBalance balance{std::vector<ColorTransform>(cameras), std::vector<int>(cameras, 0),
                      std::vector<bool>(cameras, false)};
  for (const std::vector<Sight>& sights : points)
    for (const Sight& s : sights) ++balance.points[s.camera];
  std::vector<Eigen::Vector3d> gains(cameras, Eigen::Vector3d::Zero());
  std::vector<std::array<std::vector<double>, 3>> off(cameras);
  for (int round = 0; round < kRounds; ++round) {
    for (auto& channels : off)
      for (std::vector<double>& channel : channels) channel.clear();
    for (const std::vector<Sight>& sights : points) {
      Eigen::Vector3d color = Eigen::Vector3d::Zero();
      for (const Sight& s : sights) color += s.log_color - gains[s.camera];
      color /= static_cast<double>(sights.size());
      for (const Sight& s : sights)
        for (int c = 0; c < 3; ++c)
          off[s.camera][static_cast<std::size_t>(c)].push_back(s.log_color[c] - color[c]);
    }
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    int known = 0;
    for (std::size_t i = 0; i < cameras; ++i) {
      if (balance.points[i] < kLeastPoints) continue;
      for (int c = 0; c < 3; ++c) gains[i][c] = median(off[i][static_cast<std::size_t>(c)]);
      mean += gains[i];
      ++known;
    }
    for (std::size_t i = 0; i < cameras && known > 0; ++i)
      if (balance.points[i] >= kLeastPoints) gains[i] -= mean / known;
  }
  for (std::size_t i = 0; i < cameras; ++i) balance.known[i] = balance.points[i] >= kLeastPoints;
  for (std::size_t i = 0; i < cameras; ++i)
    balance.transforms[i].matrix = (-gains[i]).array().exp().matrix().asDiagonal();
  return balance;
}

}  // namespace floatstage::calib
