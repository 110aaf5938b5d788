#include "core/working_on.h"

#include <algorithm>
#include <exception>

#include "core/working_page.h"

namespace floatstage {
namespace {

thread_local int t_depth = 0, t_exceptions = 0;

}  // namespace

WorkingPage* g_working_page = nullptr;
thread_local WorkingPage::Place* t_working_place = nullptr;

WorkingOn::WorkingOn(const std::filesystem::path& file) {
  if (g_working_page == nullptr || t_depth++ > 0) return;
  if (t_working_place == nullptr)
    t_working_place = &g_working_page->places[g_working_page->taken++ % WorkingPage::kPlaces];
  const std::string& name = file.native();
  const std::size_t length = std::min(name.size(), sizeof t_working_place->name - 1);
  std::copy_n(name.data(), length, t_working_place->name);
  t_working_place->name[length] = '\0';
  t_exceptions = std::uncaught_exceptions();
  ++t_working_place->steps;
}

WorkingOn::~WorkingOn() {
  if (g_working_page == nullptr || --t_depth > 0) return;
  if (std::uncaught_exceptions() > t_exceptions) t_working_place->failed = true;
  ++t_working_place->steps;
}

}  // namespace floatstage
