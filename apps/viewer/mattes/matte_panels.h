#pragma once

#include <string>
#include <vector>

#include "apps/viewer/mattes/matte_editor_model.h"

namespace floatstage::apps {

/// What the panels ask for beside EditorRequests.
struct MattePanelRequests {
  EditorRequests editor;
  std::string camera;  ///< serial to go to; empty: stay
};

// Each draws into the present ImGui window.

/// Camera, view, tools, edits, work in progress.
MattePanelRequests draw_matte_controls(MatteEditorModel& model);
/// Play, frame, and the line with keyframes, flicker and what is stale; a click seeks.
void draw_matte_time_line(MatteEditorModel& model);
/// The question, in a window of its own at the middle of this place, with its two answers. Only where there
/// is one.
EditorRequests draw_question(const EditorState& state, float x, float y);
/// What lies over the photograph: strokes of this keyframe, masks, what is being drawn, the brush.
void draw_edits(const MatteEditorModel& model, const EditorState& state);

}  // namespace floatstage::apps
