// SPDX-License-Identifier: Apache-2.0
#include "eos/eos.hpp"

#include <string>

#include "core/error.hpp"

namespace eos {

namespace {

void prepare(const IdealGas& gas) {
  if (!(gas.gamma > 1 && gas.cv > 0))
    throw core::CaseError("ideal_gas: gamma must exceed 1 and cv 0; they are " + std::to_string(gas.gamma) + " and " +
                          std::to_string(gas.cv) + " J/(kg K)");
}

}  // namespace

void prepare(Eos& model) {
  std::visit([](auto& m) { prepare(m); }, model);
}

double cold_energy(const Eos& model, double rho) {
  return std::visit([rho](const auto& m) { return cold_energy(m, rho); }, model);
}

double max_density(const Eos& model) {
  const auto* m = std::get_if<MieGrueneisen>(&model);
  return m ? max_density(*m) : 1e300;
}

}  // namespace eos
