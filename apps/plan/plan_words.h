#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"
#include "pipeline/plan/plan.h"

namespace floatstage::apps {

/// Stage by stage and item by item: state, machine, seconds and bytes, measured or expected.
std::string table_of(const pipeline::Plan& plan, const pipeline::PlanStatus& status);
/// Stages in the order in which they need one another, as a directed graph in Graphviz's DOT.
std::string dot_of(const pipeline::Plan& plan, const pipeline::PlanStatus& status);
nlohmann::json json_of(const pipeline::Plan& plan, const pipeline::PlanStatus& status);

/// A take and the machines that work on it.
struct FarmSize {
  int cameras = 60;
  double minutes = 10;
  double frame_rate = 0;  ///< 0: as the plan's take
  int nodes = 8;          ///< as the one that was measured, one item at a time each
};

struct FarmCost {
  std::map<std::string, double> seconds;  ///< of work, by stage
  double work = 0;                        ///< seconds of one machine
  double wall = 0;                        ///< seconds on all: last items of a kind work alone
};
/// Every stage by its measured seconds a photograph, times photographs. InvalidArgument where nothing was
/// measured, or what was is not about photographs.
Result<FarmCost> cost_of(const pipeline::Plan& plan, const pipeline::PlanStatus& status,
                         const FarmSize& farm);
std::string sentence(const FarmCost& cost, const FarmSize& farm);
nlohmann::json json_of(const FarmCost& cost);

}  // namespace floatstage::apps
