#pragma once

#include <memory>

#include "core/result.h"
#include "studio/node/capture_node.h"
#include "studio/node/publishing_node.h"

namespace floatstage::studio {

/// Lets a node tell the studio what its cameras see, as its config's [publish] says; null where there is
/// none. Before CaptureNode::begin(); the node's cameras must have stopped before the result goes. Errors:
/// the keys' file, the rig (a camera that is not in it), a plate, and those of Publisher::bind().
Result<std::unique_ptr<PublishingNode>> publish(CaptureNode& node);

}  // namespace floatstage::studio
