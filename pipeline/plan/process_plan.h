#pragma once

#include "core/result.h"
#include "pipeline/plan/plan.h"
#include "pipeline/process/process.h"

namespace floatstage::pipeline {

/// The items that matte_take() is divided into where something is to be made: "mattes", a camera's
/// photographs by `chunk`, all of a camera's where one needs another, all cameras' where they are made
/// together; and "finish", which puts the mattes into the take, after which matte_take() itself has only to
/// report. Errors: those of matte_take() that are known before anything is made.
Result<Plan> plan_mattes(const MatteTakeOptions& options, int chunk);
/// Likewise process_take(): "mattes", "gather", "meshes" by `chunk` instants, "finish".
Result<Plan> plan_process(const ProcessOptions& options, int chunk);

/// Pieces of at most `chunk` frames, each at one distance from another: first, count and step.
std::vector<PlanItem> pieces_of(const std::vector<int>& frames, int chunk);
/// A plan of one stage whose items are these pieces, and of "finish". What TakeReader::open() says.
Result<Plan> plan_of_pieces(const std::filesystem::path& take, const std::string& stage,
                            std::vector<PlanItem> pieces, double seconds_a_unit);

/// Plan::made_from of such plans: the recording, its rig, and what a person said about its mattes. What
/// TakeReader::open() says.
Result<std::string> plan_inputs(const std::filesystem::path& take);

/// Carries an item out, but for what "finish" does after the files are in their place: makes its files in a
/// view of the take in the plan's scratch, and delivers them. Returns the bytes. Io, Cancelled; what the job
/// itself would end with.
Result<std::uint64_t> run_matte_item(const Plan& plan, const PlanItem& item, const MatteTakeOptions& options);
Result<std::uint64_t> run_process_item(const Plan& plan, const PlanItem& item, const ProcessOptions& options);

}  // namespace floatstage::pipeline
