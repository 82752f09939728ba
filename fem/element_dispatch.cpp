// SPDX-License-Identifier: Apache-2.0
// Picks the kernels for this machine's instruction set.
#include "core/isa.hpp"
#include "fem/criteria_kernel.hpp"
#include "fem/element_kernel.hpp"

namespace fem {

#define EJECTA_DECLARE(isa)                                                                                        \
  namespace isa {                                                                                                  \
  ElementSums update_elements(Mesh&, const material::Material&, const ElementSettings&, const StepTimes&,          \
                              std::span<const std::uint8_t>, std::span<const std::uint32_t>);                      \
  void element_volumes(const Mesh&, std::vector<double>&);                                                         \
  void flag_blocks(const Mesh&, const Criteria&, const std::vector<double>&, double, std::span<const std::uint32_t>, std::uint8_t*); \
  }
EJECTA_DECLARE(baseline)
EJECTA_DECLARE(avx2)
EJECTA_DECLARE(avx512)
#undef EJECTA_DECLARE

ElementSums update_elements(Mesh& mesh, const material::Material& material, const ElementSettings& settings,
                            const StepTimes& times, std::span<const std::uint8_t> ring, std::span<const std::uint32_t> blocks) {
  switch (core::isa()) {
    case core::Isa::avx512: return avx512::update_elements(mesh, material, settings, times, ring, blocks);
    case core::Isa::avx2: return avx2::update_elements(mesh, material, settings, times, ring, blocks);
    default: return baseline::update_elements(mesh, material, settings, times, ring, blocks);
  }
}

void element_volumes(const Mesh& mesh, std::vector<double>& volume) {
  switch (core::isa()) {
    case core::Isa::avx512: return avx512::element_volumes(mesh, volume);
    case core::Isa::avx2: return avx2::element_volumes(mesh, volume);
    default: return baseline::element_volumes(mesh, volume);
  }
}

void flag_blocks(const Mesh& mesh, const Criteria& criteria, const std::vector<double>& rho_0, double from,
                 std::span<const std::uint32_t> blocks, std::uint8_t* flags) {
  switch (core::isa()) {
    case core::Isa::avx512: return avx512::flag_blocks(mesh, criteria, rho_0, from, blocks, flags);
    case core::Isa::avx2: return avx2::flag_blocks(mesh, criteria, rho_0, from, blocks, flags);
    default: return baseline::flag_blocks(mesh, criteria, rho_0, from, blocks, flags);
  }
}

}  // namespace fem
