#include "matting/spectral/grid_factor.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <suitesparse/cholmod.h>

#include "core/text.h"
#include "matting/blas.h"
#include "matting/spectral/nested_dissection.h"

namespace floatstage::matting {
namespace {

constexpr int kChunk = 32;  // right-hand sides a call: fewer use the factor's cache lines less, more spill

// Where an entry of the permuted lower triangle comes from.
struct Source {
  std::uint8_t plane;
  std::uint32_t pixel;
};

}  // namespace

struct GridFactor::Impl {
  int width = 0, height = 0;
  std::vector<int> order;
  std::vector<Source> sources;
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  cholmod_dense *solution = nullptr, *work_y = nullptr, *work_e = nullptr;

  Impl() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;  // the matrix is built in our order
    common.postorder = 1;
  }
  ~Impl() {
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&work_y, &common);
    cholmod_free_dense(&work_e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Unexpected refused(const char* what) const {
    return fail(ErrorCode::Unsupported,
                text("the ", width, "x", height, " matting Laplacian could not be ", what,
                     common.status == CHOLMOD_OUT_OF_MEMORY ? ": out of memory; use a smaller working size"
                                                            : text(" (CHOLMOD status ", common.status, ")")));
  }

  bool build_pattern();
};

// The permuted lower triangle: column i holds the neighbours of pixel order[i] that are eliminated later.
bool GridFactor::Impl::build_pattern() {
  const int n = width * height;
  std::vector<int> rank(n);
  for (int i = 0; i < n; ++i) rank[order[i]] = i;
  struct Entry {
    int row;
    Source source;
  };
  std::vector<int> starts{0}, rows;
  std::vector<Entry> column;
  for (int i = 0; i < n; ++i) {
    const int x = order[i] % width, y = order[i] / width;
    column.clear();
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) continue;
        const int other = order[i] + dy * width + dx;
        if (rank[other] < i) continue;
        const bool ahead = dy > 0 || (dy == 0 && dx >= 0);
        const int sx = ahead ? dx : -dx, sy = ahead ? dy : -dy;
        const int plane = sy == 0 ? sx : sy == 1 ? sx + 5 : sx + 10;
        column.push_back(
            {rank[other],
             {static_cast<std::uint8_t>(plane), static_cast<std::uint32_t>(ahead ? order[i] : other)}});
      }
    }
    std::sort(column.begin(), column.end(), [](const Entry& a, const Entry& b) { return a.row < b.row; });
    for (const Entry& e : column) {
      rows.push_back(e.row);
      sources.push_back(e.source);
    }
    starts.push_back(static_cast<int>(rows.size()));
  }
  matrix = cholmod_allocate_sparse(n, n, rows.size(), 1, 1, -1, CHOLMOD_REAL, &common);
  if (!matrix) return false;
  std::copy(starts.begin(), starts.end(), static_cast<int*>(matrix->p));
  std::copy(rows.begin(), rows.end(), static_cast<int*>(matrix->i));
  std::fill_n(static_cast<double*>(matrix->x), rows.size(), 1.0);
  return true;
}

GridFactor::GridFactor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GridFactor::GridFactor(GridFactor&&) noexcept = default;
GridFactor& GridFactor::operator=(GridFactor&&) noexcept = default;
GridFactor::~GridFactor() = default;

Result<GridFactor> GridFactor::create(int width, int height) {
  if (const auto safe = check_blas(); !safe) return forward(safe);
  const OneThread one_thread;
  auto impl = std::make_unique<Impl>();
  impl->width = width;
  impl->height = height;
  impl->order = nested_dissection(width, height);
  if (!impl->build_pattern()) return impl->refused("laid out");
  impl->factor = cholmod_analyze(impl->matrix, &impl->common);
  if (!impl->factor) return impl->refused("analysed");
  return GridFactor(std::move(impl));
}

const std::vector<int>& GridFactor::order() const { return impl_->order; }

Result<void> GridFactor::factor(const LaplacianStencil& laplacian, double shift) {
  const OneThread one_thread;
  double* values = static_cast<double*>(impl_->matrix->x);
  for (const Source& s : impl_->sources)
    *values++ = laplacian.planes[s.plane][s.pixel] + (s.plane == 0 ? shift : 0.0);
  cholmod_factorize(impl_->matrix, impl_->factor, &impl_->common);
  if (impl_->common.status == CHOLMOD_NOT_POSDEF)
    return fail(ErrorCode::Unsupported, text("the ", impl_->width, "x", impl_->height,
                                             " matting Laplacian is not positive definite at shift ", shift));
  if (impl_->common.status < CHOLMOD_OK || !impl_->factor->x) return impl_->refused("factored");
  return {};
}

Result<void> GridFactor::solve(const double* right, int columns, double* out) {
  const OneThread one_thread;
  Impl& s = *impl_;
  const std::size_t n = s.order.size();
  for (int first = 0; first < columns; first += kChunk) {
    cholmod_dense b{};
    b.nrow = b.d = n;
    b.ncol = static_cast<std::size_t>(std::min(kChunk, columns - first));
    b.nzmax = b.nrow * b.ncol;
    b.x = const_cast<double*>(right) + n * first;  // CHOLMOD only reads it
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    if (!cholmod_solve2(CHOLMOD_A, s.factor, &b, nullptr, &s.solution, nullptr, &s.work_y, &s.work_e,
                        &s.common))
      return s.refused("solved");
    std::copy_n(static_cast<const double*>(s.solution->x), b.nzmax, out + n * first);
  }
  return {};
}

std::size_t GridFactor::nonzeros() const { return impl_->factor->xsize; }
std::size_t GridFactor::bytes() const { return impl_->common.memory_usage; }

}  // namespace floatstage::matting
