#include "pipeline/matte/matte_how.h"

#include <algorithm>

#include "core/text.h"
#include "matting/keyers/keyer.h"

namespace floatstage::pipeline {

const std::vector<MatteMethod>& matte_methods() {
  static const std::vector<MatteMethod> methods = [] {
    std::vector<MatteMethod> all = {
        {"auto",
         "what explains a few photographs best: the key alone or closed form around it; what all cameras "
         "say where keys do not hold, else spectral without a key"}};
    for (const matting::KeyerInfo& k : matting::keyers()) all.push_back({k.name, k.help, true});
    all.push_back({"closed-form", "closed-form matting in the band around the key"});
    all.push_back(
        {"spectral", "spectral video matting from the key, from clicks, or from its own first guess"});
    all.push_back({"consistent",
                   "no key: what lies where the cameras look and is consistent across all their pictures"});
    all.push_back({"given", "the mattes that somebody put into the take, as they are; none is made"});
    return all;
  }();
  return methods;
}

std::string method_name(const std::string& how) { return how.substr(0, how.find(':')); }

bool is_keyer(const std::string& how) {
  const std::vector<MatteMethod>& all = matte_methods();
  return std::any_of(all.begin(), all.end(),
                     [&](const MatteMethod& m) { return m.keyer && m.name == method_name(how); });
}

Result<void> check_matte_how(const std::string& how) {
  std::string names;
  for (const MatteMethod& m : matte_methods()) {
    names += text(names.empty() ? "" : ", ", m.name);
    if (m.name == how || (m.keyer && m.name == method_name(how))) return {};
    if (m.name == method_name(how))
      return fail(ErrorCode::InvalidArgument, text("'", m.name, "' takes no parameter, as in '", how, "'"));
  }
  return fail(ErrorCode::InvalidArgument, text("no way to mattes is called '", how, "'; there are ", names));
}

}  // namespace floatstage::pipeline
