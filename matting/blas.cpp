#include "matting/blas.h"

#include <cblas.h>
#include <dlfcn.h>

namespace floatstage::matting {

namespace {

template <class Matrix>
int stride(const Matrix& m) {
  return static_cast<int>(m.outerStride());
}

}  // namespace

void transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                        const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> out) {
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, static_cast<int>(a.cols()), static_cast<int>(b.cols()),
              static_cast<int>(a.rows()), 1, a.data(), stride(a), b.data(), stride(b), 0, out.data(),
              stride(out));
}

void transposed_product(const Eigen::Ref<const Eigen::MatrixXf>& a,
                        const Eigen::Ref<const Eigen::MatrixXf>& b, Eigen::Ref<Eigen::MatrixXf> out) {
  cblas_sgemm(CblasColMajor, CblasTrans, CblasNoTrans, static_cast<int>(a.cols()), static_cast<int>(b.cols()),
              static_cast<int>(a.rows()), 1, a.data(), stride(a), b.data(), stride(b), 0, out.data(),
              stride(out));
}

void product(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b,
             Eigen::Ref<Eigen::MatrixXd> out, double factor, double scale) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, static_cast<int>(a.rows()),
              static_cast<int>(b.cols()), static_cast<int>(a.cols()), scale, a.data(), stride(a), b.data(),
              stride(b), factor, out.data(), stride(out));
}

void product(const Eigen::Ref<const Eigen::MatrixXf>& a, const Eigen::Ref<const Eigen::MatrixXf>& b,
             Eigen::Ref<Eigen::MatrixXf> out) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, static_cast<int>(a.rows()),
              static_cast<int>(b.cols()), static_cast<int>(a.cols()), 1, a.data(), stride(a), b.data(),
              stride(b), 0, out.data(), stride(out));
}

void add_outer(const Eigen::Ref<const Eigen::MatrixXf>& a, Eigen::Ref<Eigen::MatrixXf> out) {
  cblas_ssyrk(CblasColMajor, CblasLower, CblasNoTrans, static_cast<int>(a.rows()), static_cast<int>(a.cols()),
              1, a.data(), stride(a), 1, out.data(), stride(out));
}

namespace {

// Neither library may be there: a BLAS without threads has no such call.
template <class Function>
Function* find(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

Result<void> check_blas() {
  auto* kind = find<int()>("openblas_get_parallel");
  if (!kind || kind() != 0) return {};
  return fail(
      ErrorCode::Unsupported,
      "this machine's BLAS is OpenBLAS without threads, which mixes up results when frames are matted in "
      "parallel; install libopenblas0-pthread and remove libopenblas0-serial");
}

OneThread::OneThread() {
  if (auto* set_threads = find<void(int)>("openblas_set_num_threads")) set_threads(1);
  auto* get_levels = find<int()>("omp_get_max_active_levels");
  auto* set_levels = find<void(int)>("omp_set_max_active_levels");
  if (!get_levels || !set_levels) return;
  levels_ = get_levels();
  set_levels(0);
}

OneThread::~OneThread() {
  if (levels_ >= 0) find<void(int)>("omp_set_max_active_levels")(levels_);
}

}  // namespace floatstage::matting
