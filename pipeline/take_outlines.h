#pragma once

#include "core/matte.h"

namespace floatstage::pipeline {

/// The matte without what is thinner than five pixels, hair above all: one camera resolves it and another
/// does not. A grey opening (Serra 1982): straight edges stay where they are, to a fraction of a pixel. An
/// empty matte stays empty.
Matte without_strands(const Matte& matte);

}  // namespace floatstage::pipeline
