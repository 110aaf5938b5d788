#pragma once

#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {

struct MatteJob;

/// What one matte tells about itself.
struct MatteShape {
  double area = 0;    ///< share of the picture that is subject
  double border = 0;  ///< share of the picture's border that is
};
MatteShape shape_of(const Image& matte);

/// Writes into `record` why the mattes that the job has made cannot be trusted, if anything says so: they
/// were guessed, or keyed by cloth that is not most of the backdrop; most of the subject stands where its
/// found plate knows nothing; the subject covers more than half of a picture's border, as backdrops do. What
/// was given, or keyed by a guide or a person, is believed.
void note_doubts(const MatteJob& job, CameraRecord& record);

/// What the record says against the mattes of the frames that the jobs are about, with one picture for each
/// reason in mattes/doubts: of up to twelve of its cameras, each with the outline of its matte and, where
/// three others have one, of what they see. Pictures are made where mattes were made or none is there.
/// Errors: those of writing.
Result<std::vector<MatteDoubt>> doubts_of(capture::TakeReader& take, const MatteStore& store,
                                          const std::vector<MatteJob>& jobs);

}  // namespace floatstage::pipeline
