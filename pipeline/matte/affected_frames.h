#pragma once

#include <string>
#include <vector>

#include "core/matte_edits.h"

namespace floatstage::pipeline {

// None of these asks whose a stroke is: that concerns labels, not mattes.

/// Whether both say the same by strokes, frame by frame, whatever their masks.
bool same_strokes(const CameraEdits& a, const CameraEdits& b);

/// The one stroke that a subject is cut out from, or spectral components of a camera without a key are chosen
/// by: the first that marks subject in the first frame that has one. What is said beyond it guides the mattes
/// that it makes, so that a stroke more never makes others. No strokes where nothing marks subject.
MatteKeyframe seed_of(const CameraEdits& edits);

/// For each frame, whether what a person says in that very frame differs: its strokes, or the masks that hold
/// there.
std::vector<bool> edited_frames(const CameraEdits& before, const CameraEdits& after, int frames);

/// For each frame, whether spectral video matting makes another matte of it: those between the keyframes on
/// either side of one whose strokes differ, and those where masks differ. Keyframes without strokes are none.
std::vector<bool> frames_between_keyframes(const CameraEdits& before, const CameraEdits& after, int frames);

/// For each frame, whether a key's parts are chosen otherwise in it: strokes or masks differ, or it follows
/// another neighbour. All when somebody begins or ceases to choose. What follows from such a frame is
/// `downstream_of`.
std::vector<bool> frames_chosen_otherwise(const CameraEdits& before, const CameraEdits& after, int frames);

/// For each frame, whether mattes that were made by `method` from `key` (as in CameraRecord) are made
/// otherwise with other edits, but for what follows from them.
std::vector<bool> frames_made_otherwise(const std::string& method, const std::string& key,
                                        const CameraEdits& before, const CameraEdits& after, int frames);

/// `frames` and all that are made after one of them, going from the first keyframe of `edits` both ways;
/// `frames` alone where there is no keyframe. A superset of what changes: EditedCamera stops where mattes
/// come out as they were.
std::vector<bool> downstream_of(std::vector<bool> frames, const CameraEdits& edits);

}  // namespace floatstage::pipeline
