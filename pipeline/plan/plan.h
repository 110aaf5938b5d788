#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::pipeline {

/// One piece of a job that a process does by itself: run twice, or half and then again, it leaves the same
/// files.
struct PlanItem {
  std::string id;                                ///< "mattes-cam01-100"; names its files in the plan's folder
  std::string stage;                             ///< "mattes"; items of a stage do not need one another
  std::vector<std::string> cameras;              ///< serials; empty: all
  int first = 0, count = 0, step = 1;            ///< frames of the take, or pictures of a film
  std::map<std::string, std::string> with = {};  ///< what else the stage has to know
  double units = 0;                              ///< photographs, pictures or views that it is about
  double seconds = 0;                            ///< what it costs, before anything was measured
  std::uint64_t bytes_in = 0, bytes_out = 0;     ///< read and written, roughly

  std::vector<int> frames() const;
};

/// Items of one kind. A stage begins when all items of those before it are done.
struct PlanStage {
  std::string name;
  std::vector<std::size_t> items;  ///< indices into Plan::items
};

/// A job divided into items, and the folder where it is carried out:
///
///   plan.json            this
///   status.json          how far it is (PlanStatus), for whoever watches
///   items/<id>.json      how one item ended (ItemResult), written by who ran it
///   logs/<id>.log        what it said
///   done/<id>/           what it made, until the stage's last item puts it into the take
///
/// Every file is written whole under another name and renamed, by one process, so machines that share the
/// folder need no locks (docs/adr/0205-one-plan-many-machines.md).
struct Plan {
  std::filesystem::path folder;      ///< of plan.json
  std::vector<std::string> command;  ///< the words behind the program's name
  std::filesystem::path said_in;     ///< the folder in which they were said
  std::string program;               ///< SHA-256 of the program that made the plan
  std::string made_from;             ///< hash of what must not change before the plan is done
  std::filesystem::path scratch;     ///< where items work; empty: in the plan's folder
  double frame_rate = 0;             ///< of the take
  int cameras = 0;                   ///< of the take
  std::vector<PlanItem> items;       ///< stage after stage
  /// What was found while it was made, a sentence each, which its items do not say again: how `auto` makes
  /// mattes.
  std::vector<std::string> remarks = {};
  /// Frames whose mattes are old afterwards and that nobody asked to make again, by serial.
  std::map<std::string, std::set<int>> stale = {};

  const PlanItem* find(const std::string& id) const;
  std::vector<PlanStage> stages() const;

  std::filesystem::path file() const { return folder / "plan.json"; }
  std::filesystem::path result(const std::string& id) const { return folder / "items" / (id + ".json"); }
  std::filesystem::path log(const std::string& id) const { return folder / "logs" / (id + ".log"); }
  std::filesystem::path done(const std::string& id) const { return folder / "done" / id; }
  std::filesystem::path status() const { return folder / "status.json"; }
};

/// plan.json in `folder`. NotFound, BadData.
Result<Plan> load_plan(const std::filesystem::path& folder);
/// Whole or not at all. Io.
Result<void> save_plan(const Plan& plan);

/// How an item ended, last time.
struct ItemResult {
  bool done = false;
  int attempts = 0;  ///< that came to an end
  std::string node;  ///< the machine
  double seconds = 0;
  std::uint64_t bytes = 0;     ///< written
  std::optional<Error> error;  ///< why it is not done; of one that is: what its verb ends with
};
/// Nothing where it has not ended yet. BadData, Io.
Result<std::optional<ItemResult>> load_result(const Plan& plan, const std::string& id);
Result<void> save_result(const Plan& plan, const std::string& id, const ItemResult& result);

/// How far a plan is.
struct PlanStatus {
  std::map<std::string, ItemResult> ended;     ///< by item
  std::map<std::string, std::string> running;  ///< by item, where: known to who runs the plan
  std::map<std::string, double> rates;         ///< seconds a unit, measured, by stage
  int done = 0, failed = 0;
  double spent = 0;  ///< seconds of items that are done
  double left = 0;   ///< seconds of the others, by the rates; of a stage without one, as planned
  bool finished(const Plan& plan) const { return done == static_cast<int>(plan.items.size()); }
};
/// What `before` says of items that are done is not read again.
Result<PlanStatus> status_of(const Plan& plan, const PlanStatus& before = {});
/// Seconds that an item takes by what was measured.
double expected_seconds(const PlanItem& item, const PlanStatus& status);
/// Writes status.json; `at_once`: so many items run side by side, by which the time to the end is guessed.
Result<void> save_status(const Plan& plan, const PlanStatus& status, int at_once);

}  // namespace floatstage::pipeline
