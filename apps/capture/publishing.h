#pragma once

#include <memory>

#include "apps/capture/capture_node.h"
#include "apps/studio/publishing_node.h"
#include "core/result.h"

namespace floatstage {

/// Lets a node tell the studio what its cameras see, as its config's [publish] says; null where there is
/// none. Before CaptureNode::begin(); the node's cameras must have stopped before the result goes. Errors:
/// the keys' file, the rig (a camera that is not in it), a plate, and those of Publisher::bind().
Result<std::unique_ptr<PublishingNode>> publish(CaptureNode& node);

}  // namespace floatstage
