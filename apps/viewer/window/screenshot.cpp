#include "apps/viewer/window/screenshot.h"

#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::apps {

std::string keep_screenshot(const Image& picture) {
  int number = 0;
  while (is_there(text("floatstage-", number, ".png"))) ++number;
  const std::string file = text("floatstage-", number, ".png");
  const Result<void> ok = save_png(picture, file);
  return ok ? text("screenshot ", file) : ok.error().message;
}

}  // namespace floatstage::apps
