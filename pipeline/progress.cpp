#include "pipeline/progress.h"

namespace floatstage::pipeline {

Unexpected cancelled() {
  return fail(ErrorCode::Cancelled,
              "interrupted; what was finished is kept, and the same command goes on from there");
}

Unexpected cancelled_unwritten() { return fail(ErrorCode::Cancelled, "interrupted; nothing was written"); }

}  // namespace floatstage::pipeline
