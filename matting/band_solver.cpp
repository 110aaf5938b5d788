#include "matting/band_solver.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <suitesparse/cholmod.h>

#include "core/text.h"
#include "matting/blas.h"
#include "matting/held_solver.h"

namespace floatstage::matting {
namespace {

constexpr int kManyUnknowns = 100'000;             // from here on METIS' better order is worth its time
constexpr double kShifts[] = {1e-10, 1e-7, 1e-5};  // of the diagonal: keeps what nobody constrains solvable

// Owns what CHOLMOD hands out, in the order in which it must go.
struct Cholmod {
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;
  cholmod_factor* factor = nullptr;
  cholmod_dense *right = nullptr, *solution = nullptr;

  explicit Cholmod(int unknowns) {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.nmethods = 1;
    common.method[0].ordering = unknowns > kManyUnknowns ? CHOLMOD_METIS : CHOLMOD_AMD;
    common.postorder = 1;
  }
  ~Cholmod() {
    cholmod_free_dense(&right, &common);
    cholmod_free_dense(&solution, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  Unexpected refused(int unknowns) const {
    return fail(ErrorCode::Unsupported,
                text("the opacity of ", unknowns, " pixels could not be solved",
                     common.status == CHOLMOD_OUT_OF_MEMORY
                         ? ": out of memory; use a smaller picture or a tighter trimap"
                         : text(" (CHOLMOD status ", common.status, ")")));
  }
};

}  // namespace

Result<std::vector<double>> solve_band(const LaplacianStencil& stencil,
                                       const std::vector<std::uint8_t>& active,
                                       const std::vector<double>& weight, const std::vector<double>& value) {
  if (std::optional<std::vector<double>> held = solve_held_band(stencil, active, weight, value))
    return *std::move(held);
  const std::size_t pixels = stencil.pixels();
  std::vector<int> unknown_of(pixels, -1), pixel_of;
  for (std::size_t p = 0; p < pixels; ++p)
    if (active[p]) unknown_of[p] = static_cast<int>(pixel_of.size()), pixel_of.push_back(static_cast<int>(p));
  std::vector<double> out(pixels, 0.0);
  const int n = static_cast<int>(pixel_of.size());
  if (n == 0) return out;

  // The lower triangle, column by column: a pixel and those that follow it, in raster order.
  Cholmod c(n);
  c.matrix = cholmod_allocate_sparse(n, n, static_cast<std::size_t>(n) * LaplacianStencil::kSteps, 1, 1, -1,
                                     CHOLMOD_REAL, &c.common);
  c.right = c.matrix ? cholmod_allocate_dense(n, 1, n, CHOLMOD_REAL, &c.common) : nullptr;
  if (!c.right) return c.refused(n);
  int *starts = static_cast<int*>(c.matrix->p), *rows = static_cast<int*>(c.matrix->i);
  double *entries = static_cast<double*>(c.matrix->x), *right = static_cast<double*>(c.right->x);
  int count = 0;
  for (int i = 0; i < n; ++i) {
    starts[i] = count;
    const std::size_t p = static_cast<std::size_t>(pixel_of[i]);
    const int x = pixel_of[i] % stencil.width, y = pixel_of[i] / stencil.width;
    for (int k = 0; k < LaplacianStencil::kSteps; ++k) {
      const auto [dx, dy] = LaplacianStencil::step(k);
      if (x + dx < 0 || x + dx >= stencil.width || y + dy >= stencil.height) continue;
      const int other = unknown_of[p + static_cast<std::size_t>(dy) * stencil.width + dx];
      const double entry = stencil.planes[k][p] + (k == 0 ? weight[p] : 0);
      if (other < 0 || (k > 0 && entry == 0)) continue;
      rows[count] = other;
      entries[count++] = entry;
    }
    right[i] = weight[p] * value[p];
  }
  starts[n] = count;

  const OneThread one_thread;
  c.factor = cholmod_analyze(c.matrix, &c.common);
  if (!c.factor) return c.refused(n);
  bool factored = false;
  for (const double shift : kShifts) {
    double beta[2] = {shift, 0};
    factored =
        cholmod_factorize_p(c.matrix, beta, nullptr, 0, c.factor, &c.common) && c.common.status == CHOLMOD_OK;
    if (factored || c.common.status == CHOLMOD_OUT_OF_MEMORY) break;
  }
  if (!factored) return c.refused(n);
  c.solution = cholmod_solve(CHOLMOD_A, c.factor, c.right, &c.common);
  if (!c.solution) return c.refused(n);
  const double* x = static_cast<const double*>(c.solution->x);
  for (int i = 0; i < n; ++i) out[static_cast<std::size_t>(pixel_of[i])] = x[i];
  return out;
}

}  // namespace floatstage::matting
