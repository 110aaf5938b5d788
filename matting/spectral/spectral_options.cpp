#include "core/text.h"
#include "matting/spectral/spectral_matting.h"

namespace floatstage::matting {
namespace {

Result<void> within(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return fail(ErrorCode::InvalidArgument,
              text("spectral matting: ", name, " is ", value, "; it must lie between ", low, " and ", high));
}

}  // namespace

Result<void> SpectralOptions::check() const {
  if (const auto good = laplacian.check(); !good) return good;
  const struct {
    const char* name;
    double value, low, high;
  } ranges[] = {{"eigenvectors", static_cast<double>(eigenvectors), 8, 200},
                {"components", static_cast<double>(components), 2, 32},
                {"krylov_block", static_cast<double>(krylov_block), 4, 64},
                {"krylov_steps", static_cast<double>(krylov_steps), 2, 100},
                {"tolerance", tolerance, 0, 1},
                {"warm_steps", static_cast<double>(warm_steps), 1, 4},
                {"sparsity", sparsity, 0.1, 0.999},
                {"newton_steps", static_cast<double>(newton_steps), 1, 100},
                {"newton_stride", static_cast<double>(newton_stride), 1, 8},
                {"clusterings", static_cast<double>(clusterings), 1, 64}};
  for (const auto& r : ranges)
    if (const auto good = within(r.name, r.value, r.low, r.high); !good) return good;
  if (krylov_block * krylov_steps < eigenvectors + 10)
    return fail(ErrorCode::InvalidArgument, text("spectral matting: a Krylov space of ", krylov_block, " x ",
                                                 krylov_steps, " vectors is too small for ", eigenvectors,
                                                 " eigenvectors; it needs 10 more than those"));
  return {};
}

}  // namespace floatstage::matting
