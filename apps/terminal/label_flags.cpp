#include "apps/terminal/label_flags.h"

#include "apps/terminal/flags.h"

namespace floatstage::apps {

void add_label_choice(CLI::App& verb, pipeline::LabelChoice& choice) {
  CLI::Option* only =
      add_list(verb, "--label", choice.only, "Nobody but these labels of the take (matte --label)");
  add_list(verb, "--without", choice.without, "Everybody but these labels")->excludes(only);
}

}  // namespace floatstage::apps
