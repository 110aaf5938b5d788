#pragma once

#include <string>

#include "studio/messages/studio_control.h"
#include "studio/page/page_connection.h"
#include "studio/page/page_request.h"
#include "studio/page/zoom_feed.h"

namespace floatstage::studio {

/// Whether it changes something, and must be POSTed: takes are begun and ended, knobs turned, presets kept
/// and set.
bool is_order(const PageRequest& request);
/// Whether cameras are waited for.
bool is_order_to_cameras(const PageRequest& request);
/// Carries it out; waits as `control` does.
PageAnswer carry_out(StudioControl& control, const PageRequest& order);

/// Whether it is answered from what the node knows.
bool is_question(const PageRequest& request);
PageAnswer answer_question(const StudioControl& control, const std::string& path);

/// GET /api/zoom?camera=0&x=0.5&y=0.5: a JPEG of what the camera of that place sees there (ZoomFeed::look()).
PageAnswer look(ZoomFeed& feed, std::size_t cameras, const PageRequest& request);

}  // namespace floatstage::studio
