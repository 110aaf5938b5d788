#pragma once

#include <nlohmann/json.hpp>

#include "core/measured.h"

namespace floatstage::pipeline {

/// object[key] is the number, or null; then object["not_measured"][key] says why. What a number
/// rests on stands in object["counts"][key].
inline void put(nlohmann::json& object, const char* key, const Measured& m) {
  object[key] = m ? nlohmann::json(*m) : nlohmann::json(nullptr);
  if (m)
    object["counts"][key] = m.count();
  else
    object["not_measured"][key] = m.because();
}

}  // namespace floatstage::pipeline
