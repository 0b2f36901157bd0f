#include "clients/espalier/validation/built_in_tables.h"

#include <algorithm>
#include <array>
#include <cstddef>

// The assembler copies the files into the program, as in clients/web/pages.cpp.
#define ESPALIER_TABLE(name)                                                                       \
  __asm__(".section .rodata\nespalierTable_" #name "_begin:\n.incbin \"" ESPALIER_TABLES "/" #name \
          ".tsv\"\nespalierTable_" #name "_end:\n.byte 0\n.previous\n");                           \
  extern "C" const char espalierTable_##name##_begin[];                                            \
  extern "C" const char espalierTable_##name##_end[]

ESPALIER_TABLE(m21_infiltration);
ESPALIER_TABLE(m21_totals);
ESPALIER_TABLE(m22_evaporation);
ESPALIER_TABLE(m32_uptake_fractions);
ESPALIER_TABLE(rami4pilps);
ESPALIER_TABLE(rami_crowns_239);
ESPALIER_TABLE(rami_crowns_398);
ESPALIER_TABLE(rami_crowns_80);
ESPALIER_TABLE(root_conductivities);
ESPALIER_TABLE(sun_positions);

namespace espalier::validation {

namespace {

struct BuiltIn {
  std::string_view name;
  const char* begin;
  const char* end;
};

#define ESPALIER_ROW(name)                                                 \
  BuiltIn {                                                                \
#name ".tsv", espalierTable_##name##_begin, espalierTable_##name##_end \
  }

const std::array<BuiltIn, 10>& tables() {
  static const std::array<BuiltIn, 10> kTables{ESPALIER_ROW(m21_infiltration),    ESPALIER_ROW(m21_totals),
                                               ESPALIER_ROW(m22_evaporation),     ESPALIER_ROW(m32_uptake_fractions),
                                               ESPALIER_ROW(rami4pilps),          ESPALIER_ROW(rami_crowns_239),
                                               ESPALIER_ROW(rami_crowns_398),     ESPALIER_ROW(rami_crowns_80),
                                               ESPALIER_ROW(root_conductivities), ESPALIER_ROW(sun_positions)};
  return kTables;
}

struct Source {
  std::string_view name;  // without the suffix
  std::string_view sentence;
};

constexpr std::array kSources{
    Source{"m1_root_traits", "Its authors publish the plants with Schnepf et al. 2020, doi 10.3389/fpls.2020.00316"},
    Source{"m32_roots",
           "Its authors publish the roots with Schnepf et al. 2020, doi 10.3389/fpls.2020.00316, in "
           "github.com/RSA-benchmarks/collaborative-comparison, 'M3 Water flow in roots/M3.2 Root "
           "system/root_grid/RootSystem.rsml'"},
    Source{"c12_roots",
           "Its authors publish the roots with Schnepf et al. 2020, doi 10.3389/fpls.2020.00316, in "
           "github.com/RSA-benchmarks/collaborative-comparison, 'C1 Coupled problem, static RSA/C1.2 Root "
           "system/root_grid/RootSystem.rsml'"},
    Source{"c12_transpiration",
           "Its authors publish the curve with Schnepf et al. 2023, doi 10.1093/insilicoplants/diad005, in "
           "github.com/RSA-benchmarks/collaborative-comparison, 'C1 Coupled problem, static RSA/C1.2 Root system/C1.2a "
           "Numerical results/reference'"},
    Source{"c12_sinks",
           "Its authors publish the curves with Schnepf et al. 2023, doi 10.1093/insilicoplants/diad005, in "
           "github.com/RSA-benchmarks/collaborative-comparison, 'C1 Coupled problem, static RSA/C1.2 Root system/C1.2a "
           "Numerical results - sinks/0reference'"}};

}  // namespace

std::optional<std::string> builtInTable(std::string_view name) {
  const auto found = std::find_if(tables().begin(), tables().end(), [&](const auto& one) { return one.name == name; });
  return found == tables().end() ? std::nullopt : std::optional(std::string(found->begin, found->end));
}

std::vector<std::string_view> builtInTableNames() {
  std::vector<std::string_view> names;
  for (const BuiltIn& one : tables()) {
    names.push_back(one.name);
  }
  return names;
}

std::string_view sourceOfTable(std::string_view missing) {
  const auto found = std::find_if(kSources.begin(), kSources.end(), [&](const Source& one) {
    return missing.starts_with(one.name) && missing.substr(one.name.size()).starts_with(".");
  });
  return found == kSources.end() ? std::string_view() : found->sentence;
}

}  // namespace espalier::validation
