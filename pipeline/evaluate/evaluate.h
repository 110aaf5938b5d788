#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/evaluate/inputs.h"
#include "pipeline/evaluate/proxy.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/progress.h"
#include "render/renderer.h"

namespace floatstage::pipeline {

struct EvaluateOptions {
  std::vector<std::string> inputs = {}, hold_out = {};  ///< as choose_inputs() has them
  std::vector<std::string> methods = {"nearest", "linear", "floating"};
  std::vector<int> frames = {0};
  int frame_before =
      -1;  ///< drawn for the flicker of the first of them alone, where that follows it; -1: none
  render::RendererOptions renderer;
  bool balance = false;  ///< cameras' colours are brought to one another, without the held-out one's
  Proxy proxy;
  int scale = 1;    ///< pictures are drawn and compared at 1/scale of the photographs' size
  int border = -1;  ///< px of the compared picture that do not count along its sides; -1: none, or a twelfth
                    ///< of its width where nothing has mattes
  bool classes = false;          ///< what plain blending does to each pixel is predicted and measured, too
  Progress* progress = nullptr;  ///< null: unwatched
};

/// One held-out photograph against its reconstructions from the other cameras.
struct HeldOutView {
  std::string serial;
  int frame = 0;
  Image truth;                  ///< RGB, as a pinhole would have seen it, at 1/scale
  Image silhouette;             ///< its matte, 1 channel; without one, the proxy as it sees it
  bool has_matte = true;        ///< false: the camera is only truth
  bool whole_pictures = false;  ///< nothing has mattes: all of the photographs is drawn
  Image seen;                   ///< 255 where its lens has seen, 0 where something was added to its pictures
  Image mask;                   ///< where scores are taken: truth silhouette AND proxy AND seen, eroded 2 px
  std::map<std::string, Image> rendered;  ///< per method, RGB over black
  std::map<std::string, Scores> scores;   ///< per method
};

/// Leave-one-out on a processed take: each held-out photograph is never used (not for the hull, colour or
/// flow), every other input stays. What follows the frame before gets its flicker. A camera without a matte
/// is only truth: it is never an input, and is scored where the proxy is; but where no camera of the take has
/// one, as in a light field, all are inputs. Calls `report` once per view as soon as it is done. The
/// renderer's back-end must be open (open_back_end()).
Result<void> evaluate_take(capture::TakeReader& take, const EvaluateOptions& options,
                           const std::function<Result<void>(HeldOutView)>& report);

/// A view as the camera sees it, its lens taken out; near and far around `mesh`.
View view_of_camera(const RigCamera& camera, const Mesh& mesh);

}  // namespace floatstage::pipeline
