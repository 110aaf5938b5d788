#pragma once

#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"
#include "pipeline/matte/camera_matting.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {

struct MatteJob;

/// What one matte tells about itself.
struct MatteShape {
  double area = 0;     ///< share of the picture that is subject
  double border = 0;   ///< share of the picture's border that is
  double passing = 0;  ///< share of the picture that may come or go across that much border from a frame to
                       ///< the next
};
MatteShape shape_of(const Image& matte);

/// Writes into `record` what strokes had to do with a matte that was put into its place, and what could not
/// be followed into it, which is doubted.
void note_guidance(const CameraMatting::Link& made, CameraRecord& record);

/// A matte that lies there, as the neighbour of one that is made: one of ours that strokes did not make
/// another hands nothing on, whatever the other cameras' evidence made of it since. `record`: of the camera;
/// null: there is none.
CameraMatting::Link link_of(const CameraRecord* record, int frame, Image matte);

/// Whether the matte of a frame that the others' evidence made stays where strokes alone are others than they
/// were: they make nothing of it (`made`), and what those of its frame mark is so in it.
bool heals_on(MatteStore& store, const std::string& serial, const CameraEdits& edits,
              const CameraMatting::Link& made);

/// Writes into `record` what strokes had to do with the mattes that the job has made, and why those cannot be
/// trusted, if anything says so: what strokes changed could not be followed; they were guessed, or keyed by
/// cloth that is not most of the backdrop; most of the subject stands where its found plate knows nothing, or
/// nothing stands out from that plate; the subject covers more than half of a picture's border, as backdrops
/// do; more than half of it comes or goes from a frame to the next. What a guide keyed is believed; of a
/// person's clicks only sizes are judged.
void note_doubts(const MatteJob& job, CameraRecord& record);

/// What the record says against the mattes of the frames that the jobs are about, with one picture for each
/// reason in mattes/doubts: of up to twelve of its cameras, each with the outline of its matte and, where
/// three others have one, of what they see. Pictures are made where mattes were made or none is there.
/// Errors: those of writing.
Result<std::vector<MatteDoubt>> doubts_of(capture::TakeReader& take, const MatteStore& store,
                                          const std::vector<MatteJob>& jobs);

}  // namespace floatstage::pipeline
