// SPDX-License-Identifier: Apache-2.0
#pragma once
namespace eos {
struct IdealGas {
  double gamma = 1.4;  ///< ratio of specific heats [-]
  double cv = 718;     ///< [J/(kg K)]
};
}
