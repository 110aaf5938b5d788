#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/mattes/edit_session.h"
#include "apps/viewer/mattes/matte_picture.h"
#include "apps/viewer/mattes/picture_fit.h"
#include "apps/viewer/window/input_event.h"
#include "apps/viewer/window/time_line.h"

namespace floatstage::apps {

/// Everything that hands can change in the matte editor, without a window: input and panels write it, the
/// canvas reads it.
struct EditorState {
  TimeLine time;
  EditSession session;
  PictureFit fit;
  MatteView view = MatteView::Checker;
  bool automatic = true;  ///< mattes are made again after every edit

  std::vector<bool> stale = {};   ///< a frame
  std::vector<bool> guided = {};  ///< a frame: strokes, its own or carried ones, act in it
  std::map<int, std::vector<std::string>> doubts = {};  ///< by frame: why its matte is not to be trusted
  std::vector<std::optional<double>> flicker = {};      ///< a frame; absent: not metered yet
  std::vector<int> worst = {};                          ///< worst_frames(flicker)

  double pointer_x = 0, pointer_y = 0;   ///< px of the window
  int held = -1;                         ///< button that went down over the photograph
  std::vector<std::string> labels = {};  ///< of whom strokes may be; session.subject is one of them or none
  std::string new_label = {};            ///< being written
  std::string status = {};
  std::string question = {};  ///< to be answered by yes or no before anything else is drawn; empty: none
};

/// What was asked for and is not done in the state itself.
struct EditorRequests {
  bool edited = false;  ///< the session's edits have changed
  bool remake = false, screenshot = false, next_camera = false, player = false, quit = false;
  bool yes = false, no = false;  ///< to the question
  void add(const EditorRequests& other) {
    edited |= other.edited, remake |= other.remake, screenshot |= other.screenshot;
    next_camera |= other.next_camera, player |= other.player, quit |= other.quit;
    yes |= other.yes, no |= other.no;
  }
};

/// Mouse and keys of the matte editor; docs/editing-mattes.md lists them.
EditorRequests take_input(const InputEvent& event, EditorState& state);

void go_to_worst(EditorState& state);
/// The strokes to come are the next label's; after the last nobody's in particular.
void choose_next_label(EditorState& state);
/// They are this label's, which is new or known; false, with a sentence in the status, for a name that is
/// none.
bool choose_label(EditorState& state, const std::string& name);

}  // namespace floatstage::apps
