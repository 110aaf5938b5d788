// Method:  the subset of components that fits what is wanted, through their Gram matrix
// Paper:   the thesis, eq. 7.5 and 7.6
// Differs: all subsets by a Gray code up to 16 components, so that the choice is the best one, not a greedy
//          one
// ADR:     0094

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "core/text.h"
#include "matting/blas.h"
#include "matting/spectral/spectral_matting.h"

namespace floatstage::matting {
namespace {

constexpr int kEnumerable = 16;     // components whose subsets are all tried
constexpr double kTieBreak = 1e-9;  // price of area: of subsets that are as good the smallest wins
constexpr double kSmallestGuess =
    0.02;                      // share of the picture that either side of a first guess has at least
constexpr double kFree = 0.1;  // of the border: a subject that covers more is taken only when nothing else is

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// E(b) = constant + sum of b_i (linear_i + sum_j quadratic_ij b_j): any sum of squared differences to sums of
// components, and any price on single components.
struct SubsetEnergy {
  MatrixXd quadratic;
  VectorXd linear;
  double constant = 0;

  // What E gains when component i joins or leaves the subset b.
  double change(const VectorXd& b, Index i) const {
    const double sign = b(i) > 0 ? -1 : 1;
    return sign * (linear(i) + 2 * (quadratic.col(i).dot(b) - quadratic(i, i) * b(i)) + quadratic(i, i));
  }
};

// Walks all subsets in Gray code, one component joining or leaving at a time, and keeps the cheapest.
template <class Visit>
void for_each_subset(const SubsetEnergy& energy, Visit visit) {
  const Index k = energy.linear.size();
  VectorXd b = VectorXd::Zero(k);
  double value = energy.constant;
  visit(b, value);
  for (std::uint32_t i = 1; i < (1u << k); ++i) {
    const Index flip = std::countr_zero(i);
    value += energy.change(b, flip);
    b(flip) = 1 - b(flip);
    visit(b, value);
  }
}

Selection cheapest_of_all(const SubsetEnergy& energy) {
  VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  for_each_subset(energy, [&](const VectorXd& b, double value) {
    if (value < least) {
      least = value;
      best = b;
    }
  });
  Selection selection{std::vector<bool>(static_cast<std::size_t>(best.size())), std::max(least, 0.0)};
  for (Index i = 0; i < best.size(); ++i) selection.chosen[static_cast<std::size_t>(i)] = best(i) > 0;
  return selection;
}

// Thesis section 7.3.3: start from nothing, always make the change that gains the most. (Eq. 7.6 excludes
// components that raise the energy on their own; here they are never taken while they do.)
Selection greedy(const SubsetEnergy& energy) {
  const Index k = energy.linear.size();
  VectorXd b = VectorXd::Zero(k);
  double value = energy.constant;
  for (;;) {
    Index best = -1;
    double gain = -1e-15;
    for (Index i = 0; i < k; ++i)
      if (const double change = energy.change(b, i); change < gain) {
        gain = change;
        best = i;
      }
    if (best < 0) break;
    b(best) = 1 - b(best);
    value += gain;
  }
  Selection selection{std::vector<bool>(static_cast<std::size_t>(k)), std::max(value, 0.0)};
  for (Index i = 0; i < k; ++i) selection.chosen[static_cast<std::size_t>(i)] = b(i) > 0;
  return selection;
}

Result<void> fits(const Image& image, const MattingComponents& components, const char* what) {
  if (image.width == components.width && image.height == components.height && image.channels == 1) return {};
  return fail(
      ErrorCode::InvalidArgument,
      text("the ", what, " of an opinion on the matte is ", image.width, "x", image.height, " with ",
           image.channels, " channels; the components are ", components.width, "x", components.height));
}

// All terms as one: a weight a pixel and the weighted mean of what is wanted there.
struct Wanted {
  VectorXd weight, opacity;
  double spread = 0;  // what the terms disagree by among themselves
};

Result<Wanted> combined(const MattingComponents& components, const std::vector<SelectionTerm>& terms) {
  const Index n = components.alpha.rows();
  VectorXd weight = VectorXd::Zero(n), first = VectorXd::Zero(n), second = VectorXd::Zero(n);
  for (const SelectionTerm& term : terms) {
    const MatteConstraint& o = term.opinion;
    if (const auto good = fits(o.opacity, components, "opacity"); !good) return forward(good);
    if (!o.weight.empty())
      if (const auto good = fits(o.weight, components, "weight"); !good) return forward(good);
    if (!(term.strength >= 0 && std::isfinite(term.strength)))
      return fail(ErrorCode::InvalidArgument,
                  text("the strength of an opinion on the matte is ", term.strength));
    for (Index p = 0; p < n; ++p) {
      const auto at = static_cast<std::size_t>(p);
      const double w = term.strength * (o.weight.empty() ? 1 : o.weight.pixels[at] / 255.0);
      const double opacity = o.opacity.pixels[at] / 255.0;
      weight(p) += w;
      first(p) += w * opacity;
      second(p) += w * opacity * opacity;
    }
  }
  if (!(weight.sum() > 0))
    return fail(
        ErrorCode::InvalidArgument,
        "nothing says which components are subject; give a scribble, a matte, or a plate's likelihood");
  Wanted wanted{weight, VectorXd::Zero(n), 0};
  for (Index p = 0; p < n; ++p) {
    if (weight(p) <= 0) continue;
    wanted.opacity(p) = first(p) / weight(p);
    wanted.spread += second(p) - first(p) * wanted.opacity(p);
  }
  return wanted;
}

}  // namespace

Result<Selection> select_components(const MattingComponents& components,
                                    const std::vector<SelectionTerm>& terms,
                                    const std::vector<bool>& previous, double persistence) {
  const auto k = static_cast<std::size_t>(components.count());
  if (!previous.empty() && previous.size() != k)
    return fail(ErrorCode::InvalidArgument,
                text("the previous choice is of ", previous.size(), " components, there are ", k));
  const auto wanted = combined(components, terms);
  if (!wanted) return forward(wanted);
  const double n = static_cast<double>(components.alpha.rows());
  const VectorXd root = wanted->weight.cwiseSqrt();
  const MatrixXd weighted = root.asDiagonal() * components.alpha.cast<double>();
  const VectorXd target = root.cwiseProduct(wanted->opacity);
  SubsetEnergy energy{MatrixXd(k, k), VectorXd(k), (target.squaredNorm() + wanted->spread) / n};
  transposed_product(weighted, weighted, energy.quadratic);
  energy.quadratic /= n;
  energy.linear = weighted.transpose() * target * (-2 / n);
  const VectorXd areas = components.alpha.cwiseMax(0).cast<double>().colwise().mean();
  energy.linear += kTieBreak * areas;
  for (std::size_t i = 0; i < previous.size(); ++i) {
    const double area = areas(static_cast<Index>(i));
    energy.linear(static_cast<Index>(i)) += persistence * area * (previous[i] ? -1 : 1);
    energy.constant += previous[i] ? persistence * area : 0;
  }
  return k <= kEnumerable ? cheapest_of_all(energy) : greedy(energy);
}

Result<Selection> guess_selection(const MattingComponents& components,
                                  const Eigen::SparseMatrix<double>& laplacian) {
  if (components.empty() || laplacian.cols() != components.alpha.rows())
    return fail(ErrorCode::InvalidArgument, text("the matting Laplacian has ", laplacian.cols(),
                                                 " pixels, the components ", components.alpha.rows()));
  const MatrixXd alpha = components.alpha.cast<double>();
  // Components beyond those that can be enumerated are background: the largest are decided on.
  std::vector<Index> order(static_cast<std::size_t>(alpha.cols()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
  const VectorXd areas = alpha.cwiseMax(0).colwise().mean();
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return areas(a) > areas(b); });
  order.resize(std::min<std::size_t>(order.size(), kEnumerable));

  const auto k = static_cast<Index>(order.size());
  MatrixXd chosen(alpha.rows(), k);
  for (Index i = 0; i < k; ++i) chosen.col(i) = alpha.col(order[static_cast<std::size_t>(i)]);
  const SubsetEnergy energy{chosen.transpose() * (laplacian * chosen), VectorXd::Zero(k), 0};
  const int w = components.width, h = components.height;
  VectorXd border = VectorXd::Zero(k), area = chosen.colwise().mean();
  for (int x = 0; x < w; ++x)
    border += chosen.row(x).transpose();  // people stand: the bottom row says nothing
  for (int y = 1; y < h; ++y)
    border += (chosen.row(Index{y} * w) + chosen.row(Index{y} * w + w - 1)).transpose();
  border /= w + 2.0 * (h - 1);

  double least = std::numeric_limits<double>::infinity();
  std::optional<VectorXd> best;
  for_each_subset(energy, [&](const VectorXd& b, double value) {
    const double share = area.dot(b);
    if (share < kSmallestGuess || share > 1 - kSmallestGuess) return;
    const double touching = border.dot(b);
    if (touching > 0.5) return;  // that side is the background
    const double score =
        (std::max(value, 0.0) + 1e-12) / (share * (1 - share)) * (touching > kFree ? 1e6 : 1);
    if (score < least) {
      least = score;
      best = b;
    }
  });
  Selection selection{std::vector<bool>(static_cast<std::size_t>(components.count())), best ? least : 0.0};
  if (best)
    for (Index i = 0; i < k; ++i)
      selection.chosen[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])] = (*best)(i) > 0;
  return selection;
}

}  // namespace floatstage::matting
