// SPDX-License-Identifier: Apache-2.0
// Cost against accuracy: a case at several fidelities and in several modes.
#pragma once

#include <string>
#include <vector>

namespace app {

struct TradeRequest {
  std::string target;                                          ///< case file, or the folder that holds case.toml
  std::string out;                                             ///< folder of the study
  std::vector<std::string> modes{"hybrid", "erosion"};
  std::vector<std::string> fidelities{"draft", "standard", "fine"};  ///< names, or elements across
  std::vector<std::string> set;                                ///< overrides for all of them
  int threads = 0;                                             ///< 0: all
  bool force = false;                                          ///< runs anew what is there
};

/// Runs every mode at every fidelity, each in a process and a folder of its own, DIR/MODE-ACROSS. Those of the same case that are there and
/// have ended are kept, interrupted ones go on. Then prints and writes DIR/trade.csv and draws DIR/trade.png. A run's error is the root mean
/// square of its measurements' relative errors against the case's references; yes or no counts 0 or 1, and what a run did not measure 1. A case
/// that names no reference is judged by its finest run in the first mode. Cost is processor time. A run lies on the Pareto front if none that costs
/// no more errs less. Returns the exit code: 0, 2 where a run refused its case, 130 interrupted. Throws core::CaseError before anything is run.
int trade(const TradeRequest& request);

/// Which of them lie on the Pareto front: those that nothing beats which costs no more; of equals the first.
std::vector<bool> pareto_front(const std::vector<double>& cost, const std::vector<double>& error);

}  // namespace app
