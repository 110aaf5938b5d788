#pragma once

#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::pipeline {

/// One way to mattes, as `--matte HOW` names it.
struct MatteMethod {
  std::string name, help;
  bool keyer = false;  ///< one of matting::keyers(), which may have a parameter: "luminance:30"
};
/// auto, the keyers, and what needs more than one photograph's colours.
const std::vector<MatteMethod>& matte_methods();

/// "luminance" of "luminance:30".
std::string method_name(const std::string& how);
/// Whether `how` is a keyer's word.
bool is_keyer(const std::string& how);

/// InvalidArgument, with all names, for what is none of matte_methods() or has a parameter where none is
/// taken. A keyer's parameter is checked when it is made.
Result<void> check_matte_how(const std::string& how);

}  // namespace floatstage::pipeline
