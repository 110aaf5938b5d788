#pragma once

#include "core/result.h"
#include "pipeline/evaluate/inputs.h"
#include "pipeline/evaluate/proxy.h"
#include "render/scene.h"

namespace floatstage::pipeline {

/// The scene of an instant on `proxy` from its inputs, without camera `held` (-1: nobody). With `balance` the
/// cameras' colours are brought to one another by what the inputs see. Errors as Scene::set().
Result<void> set_scene(const Rig& rig, const Instant& instant, const Mesh& proxy, int held,
                       const Inputs& inputs, bool balance, render::Scene& out);

}  // namespace floatstage::pipeline
