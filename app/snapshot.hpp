// SPDX-License-Identifier: Apache-2.0
// What is stored and what is measured: the state as a snapshot, a snapshot as matter.
#pragma once

#include "app/simulation.hpp"
#include "io/snapshot.hpp"
#include "measure/matter.hpp"

namespace app {

/// Everything alive, for run.h5: how much it is, and its parts, each made when it is its turn.
io::SnapshotSize snapshot_size(const Simulation& s);
void give_snapshot(const Simulation& s, io::SnapshotSink& to);
/// The same as a copy.
io::Snapshot take_snapshot(const Simulation& s);

/// The matter of a snapshot: measuring a run and measuring its stored state go through here both.
measure::Matter matter_of(io::Snapshot snapshot);

/// The scene with what was recorded while running: time, impulses, peak pressures.
measure::Scene scene_now(const Simulation& s);

/// Fills the scene's recorded values from a snapshot; returns the clouds frozen by then. Throws CaseError where the snapshot is
/// not of this scene's mesh.
std::vector<measure::Value> recall(const io::Snapshot& snapshot, measure::Scene& scene);

/// All measurements of a snapshot, clouds as frozen.
measure::Result measure_snapshot(io::Snapshot snapshot, const measure::Scene& scene,
                                 const std::vector<measure::Value>& frozen);

/// Measures the cloud behind a plate at the moment when its front comes near the next plate, once. To be asked after every step.
void freeze_clouds(Simulation& s);

}  // namespace app
