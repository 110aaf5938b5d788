#pragma once

#include <Eigen/Core>

#include "core/result.h"

// Private to the stage: dense products by the machine's BLAS, which picks its kernels for the CPU it runs on.
namespace floatstage::matting {

/// out = a' b, for tall a and b.
void transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                        const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> out);
void transposed_product(const Eigen::Ref<const Eigen::MatrixXf>& a,
                        const Eigen::Ref<const Eigen::MatrixXf>& b, Eigen::Ref<Eigen::MatrixXf> out);

/// out = factor * out + scale * a b, for tall a and small b.
void product(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b,
             Eigen::Ref<Eigen::MatrixXd> out, double factor = 0, double scale = 1);
void product(const Eigen::Ref<const Eigen::MatrixXf>& a, const Eigen::Ref<const Eigen::MatrixXf>& b,
             Eigen::Ref<Eigen::MatrixXf> out);

/// Adds a a' to the lower triangle of out; a is small x long.
void add_outer(const Eigen::Ref<const Eigen::MatrixXf>& a, Eigen::Ref<Eigen::MatrixXf> out);

/// While one lives, BLAS and CHOLMOD stay on the calling thread: we run frames in parallel, and two levels of
/// threads are slower than one (CHOLMOD asks OpenMP for four threads whatever the machine). OpenMP's limit is
/// the calling thread's and is restored; that of a threaded OpenBLAS is the process's and stays.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int levels_ = -1;  // what OpenMP had before, where there is OpenMP
};

/// Unsupported when the machine's BLAS mixes up the results of threads that call it at the same time:
/// OpenBLAS built without threads (Debian's libopenblas0-serial) shares its work buffers between callers.
Result<void> check_blas();

}  // namespace floatstage::matting
