// SPDX-License-Identifier: Apache-2.0
// Unit strings: values by hand, every dimension's own example, and what is said about wrong ones. Powers of ten must be
// exact, so these compare bits.
#include "core/units.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "core/error.hpp"

namespace {

using core::Dimension;
using core::parse_quantity;

std::string error_of(std::string_view text, Dimension d) {
  try {
    const double value = parse_quantity(text, d);
    return "accepted as " + core::exact_decimal(value);
  } catch (const core::CaseError& e) {
    return e.what();
  }
}

void expect_parts(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
}

TEST(Units, DecimalPrefixesAreExact) {
  EXPECT_EQ(parse_quantity("4 mm", Dimension::length), 0.004);
  EXPECT_EQ(parse_quantity("2.05 mm", Dimension::length), 0.00205);
  EXPECT_EQ(parse_quantity("0.8mm", Dimension::length), 0.0008);
  EXPECT_EQ(parse_quantity("8 km/s", Dimension::velocity), 8000.0);
  EXPECT_EQ(parse_quantity("-1e3 m/s", Dimension::velocity), -1000.0);
  EXPECT_EQ(parse_quantity("+7.1 km/s", Dimension::velocity), 7100.0);
  EXPECT_EQ(parse_quantity("8 mm/us", Dimension::velocity), 8000.0);
  EXPECT_EQ(parse_quantity("20 us", Dimension::time), 20e-6);
  EXPECT_EQ(parse_quantity("20 \u00b5s", Dimension::time), 20e-6);
  EXPECT_EQ(parse_quantity("20 \u03bcs", Dimension::time), 20e-6);
  EXPECT_EQ(parse_quantity("0.3 ns", Dimension::time), 0.3e-9);
  EXPECT_EQ(parse_quantity("1.2 GPa", Dimension::pressure), 1.2e9);
  EXPECT_EQ(parse_quantity("265 MPa", Dimension::pressure), 265e6);
  EXPECT_EQ(parse_quantity("1.1 Mbar", Dimension::pressure), 1.1e11);
  EXPECT_EQ(parse_quantity("2785 kg/m3", Dimension::density), 2785.0);
  EXPECT_EQ(parse_quantity("2785 kg m^-3", Dimension::density), 2785.0);
  EXPECT_EQ(parse_quantity("2785 kg/m\u00b3", Dimension::density), 2785.0);
  EXPECT_EQ(parse_quantity("4.2 g/cm3", Dimension::density), 4200.0);
  EXPECT_EQ(parse_quantity("4.2 g/cm^3", Dimension::density), 4200.0);
  EXPECT_EQ(parse_quantity("4.2 g/cc", Dimension::density), 4200.0);
  EXPECT_EQ(parse_quantity("875 J/(kg K)", Dimension::specific_heat), 875.0);
  EXPECT_EQ(parse_quantity("875 J/kg/K", Dimension::specific_heat), 875.0);
  EXPECT_EQ(parse_quantity("875 J/(kg*K)", Dimension::specific_heat), 875.0);
  EXPECT_EQ(parse_quantity("0.875 kJ/(kg\u00b7K)", Dimension::specific_heat), 875.0);
  EXPECT_EQ(parse_quantity("2.5 MJ/kg", Dimension::specific_energy), 2.5e6);
  EXPECT_EQ(parse_quantity("2.5 km2/s2", Dimension::specific_energy), 2.5e6);
  EXPECT_EQ(parse_quantity("294 K", Dimension::temperature), 294.0);
  EXPECT_EQ(parse_quantity("0.5 rad", Dimension::angle), 0.5);
  EXPECT_EQ(parse_quantity("1 1/s", Dimension::rate), 1.0);
  EXPECT_THROW(parse_quantity("1 1 mm", Dimension::length), std::exception);
  EXPECT_THROW(parse_quantity("7 1", Dimension::length), std::exception);
  EXPECT_EQ(parse_quantity("3 s^-1", Dimension::rate), 3.0);
  EXPECT_EQ(parse_quantity("94 mg", Dimension::mass), 94e-6);
  EXPECT_EQ(parse_quantity("9.81 m/s2", Dimension::acceleration), 9.81);
  EXPECT_EQ(parse_quantity("100 rad/s", Dimension::angular_velocity), 100.0);
  EXPECT_EQ(parse_quantity("100 1/s", Dimension::angular_velocity), 100.0);
  EXPECT_THROW(parse_quantity("100 Hz", Dimension::angular_velocity), std::exception) << "turns or radians";
  EXPECT_EQ(parse_quantity("100 Hz", Dimension::rate), 100.0);
  EXPECT_EQ(parse_quantity("0.0154 1/GPa", Dimension::inverse_pressure), 0.0154e-9);
  EXPECT_EQ(parse_quantity("6.2e-4 1/K", Dimension::inverse_temperature), 6.2e-4);
  EXPECT_EQ(parse_quantity("0.5 N s", Dimension::momentum), 0.5);
  EXPECT_EQ(parse_quantity("2.5 kJ", Dimension::energy), 2500.0);
}

TEST(Units, OtherUnitsHaveTheirFactor) {
  // one rounding of the factor and one of the product
  EXPECT_DOUBLE_EQ(parse_quantity("45 deg", Dimension::angle), 0.78539816339744831);
  EXPECT_DOUBLE_EQ(parse_quantity("45\u00b0", Dimension::angle), 0.78539816339744831);
  EXPECT_DOUBLE_EQ(parse_quantity("30 rpm", Dimension::angular_velocity), 3.1415926535897931);
  EXPECT_DOUBLE_EQ(parse_quantity("0.25 in", Dimension::length), 0.00635);
  EXPECT_DOUBLE_EQ(parse_quantity("50 mil", Dimension::length), 0.00127);
  EXPECT_DOUBLE_EQ(parse_quantity("10 ksi", Dimension::pressure), 68947572.93168361);
  EXPECT_DOUBLE_EQ(parse_quantity("10 min", Dimension::time), 600.0);
  EXPECT_DOUBLE_EQ(parse_quantity("23000 ft/s", Dimension::velocity), 7010.4);
}

TEST(Units, BareNumberIsSi) {
  EXPECT_EQ(parse_quantity("0.004", Dimension::length), 0.004);
  EXPECT_EQ(parse_quantity(" -8e3 ", Dimension::velocity), -8000.0);
  EXPECT_EQ(parse_quantity("2.5", Dimension::none), 2.5);
}

TEST(Units, EveryDimensionReadsItsOwnExample) {
  for (int k = 0; k <= static_cast<int>(Dimension::surface_energy); ++k) {
    const auto d = static_cast<Dimension>(k);
    EXPECT_NO_THROW(parse_quantity(core::dimension_example(d), d)) << core::dimension_name(d);
    if (*core::si_unit(d)) {
      EXPECT_EQ(parse_quantity(std::string("3 ") + core::si_unit(d), d), 3.0) << core::dimension_name(d);
    }
  }
  EXPECT_STREQ(core::dimension_name(Dimension::momentum), "momentum");  // the table is in the order of the enum
  EXPECT_STREQ(core::dimension_name(Dimension::energy), "energy");
}

TEST(Units, WrongDimensionSaysWhatWasGivenAndWhatIsNeeded) {
  expect_parts(error_of("4 kg", Dimension::length), {"'4 kg' is a mass", "a length is needed", "4 mm"});
  expect_parts(error_of("8 km", Dimension::velocity), {"is a length", "a velocity is needed", "8 km/s"});
  expect_parts(error_of("5 mm", Dimension::time), {"a time is needed", "20 us"});
  expect_parts(error_of("2 m", Dimension::none), {"a pure number is needed", "0.5"});
  expect_parts(error_of("3 W m", Dimension::length), {"unknown name 'W'"});
  expect_parts(error_of("3 m4", Dimension::length), {"in m^4"});
  expect_parts(error_of("875 J/kg K", Dimension::specific_heat), {"875 J/(kg K)"});
  expect_parts(error_of("20 rad", Dimension::none), {"is an angle"});
}

TEST(Units, UnreadableTextIsRefused) {
  expect_parts(error_of("4 mn", Dimension::length), {"unknown name 'mn'", "4 mm"});
  expect_parts(error_of("", Dimension::length), {"does not begin with a number"});
  expect_parts(error_of("mm", Dimension::length), {"does not begin with a number"});
  expect_parts(error_of("1,5 mm", Dimension::length), {"comma", "point"});
  expect_parts(error_of("inf m", Dimension::length), {"does not begin with a number"});
  expect_parts(error_of("nan", Dimension::length), {"does not begin with a number"});
  expect_parts(error_of("1e999 m", Dimension::length), {"out of the range"});
  expect_parts(error_of("1e308 km", Dimension::length), {"out of the range"});
  expect_parts(error_of("0x10 m", Dimension::length), {"unknown name 'x'"});
  expect_parts(error_of("4 mm mm", Dimension::length), {"in m^2"});
  expect_parts(error_of("4 m/", Dimension::length), {"missing at the end"});
  expect_parts(error_of("4 J/(kg K", Dimension::specific_heat), {"')' is missing"});
  expect_parts(error_of("4 m)", Dimension::length), {"unexpected ')'"});
  expect_parts(error_of("4 m^", Dimension::length), {"whole number"});
  expect_parts(error_of("4 mm 5", Dimension::length), {"unexpected '5'"});
  expect_parts(error_of("4 (((((((((((m9)9)9)9)9)9)9)9)9)9)9)9", Dimension::length), {"too many brackets"});
  expect_parts(error_of("4 " + std::string(1000000, '('), Dimension::length), {"too many brackets"});
}

TEST(Units, ExactDecimalReadsBackToTheSameBits) {
  for (const double value : {0.1, 1.0 / 3.0, 2.05e-3, -8000.0, 1e300, 5e-324, 0.0, -0.0, 1e19, 12345678901234567890.0, 6894.757293168361}) {
    double back = -1;
    ASSERT_TRUE(core::parse_number(core::exact_decimal(value), back)) << core::exact_decimal(value);
    EXPECT_EQ(std::memcmp(&back, &value, sizeof(double)), 0) << core::exact_decimal(value);
  }
  double ignored;
  for (const char* text : {"", "1 ", "1x", "--1", ".", "e5"}) EXPECT_FALSE(core::parse_number(text, ignored)) << text;
}

}  // namespace
