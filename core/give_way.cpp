#include "core/give_way.h"

#include <sys/resource.h>
#include <unistd.h>

namespace floatstage {

void give_way(int nice) { ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), nice); }

}  // namespace floatstage
