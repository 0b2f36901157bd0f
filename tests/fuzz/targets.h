#pragma once

#include <string_view>

namespace espalier::fuzz {

/// Gives a text to a part of the engine that reads what strangers write. Whatever the text is, a target returns: a
/// message to the text's author is an answer, an exception or a check that fails is a finding. Texts are bundles
/// (bundle.h).
using Target = void (*)(std::string_view text);

void fuzzPreprocessor(std::string_view text);
void fuzzCompile(std::string_view text);     // a file of models, in every mode; what compiles is disassembled
void fuzzViewFile(std::string_view text);    // a view file with the files it names, in the Espalier and the Cpfg mode
void fuzzDerivation(std::string_view text);  // a model, a few steps and its scene, within small limits; then a snapshot
void fuzzMessages(std::string_view bytes);   // the wire: bytes cut into messages, every decoder; text and blocks agree
void fuzzSnapshot(std::string_view bytes);   // a snapshot, its checksum made right: compiled, restored, two more steps
void fuzzTrace(std::string_view bytes);      // a trace, its checksums made right, replayed
void fuzzString(std::string_view text);      // a bundle of a string and its model: the run begins with the string
void fuzzMtg(std::string_view text);         // a multiscale tree graph, read into strings
void fuzzPoints(std::string_view bytes);     // a point cloud: LAS or PLY
void fuzzTerrain(std::string_view bytes);    // a GeoTIFF of heights
void fuzzForest(std::string_view text);      // a forest file with its models: read, placed, a few steps
void fuzzRoots(std::string_view text);       // a root system: RSML, or a table; its model
void fuzzVti(std::string_view text);         // image data of VTK, as an environment begins with them

struct NamedTarget {
  std::string_view name;  // as its folder of regressions and its program
  Target run;
};
inline constexpr NamedTarget kTargets[] = {
    {"preprocessor", fuzzPreprocessor},
    {"compile", fuzzCompile},
    {"view_file", fuzzViewFile},
    {"derivation", fuzzDerivation},
    {"messages", fuzzMessages},
    {"snapshot", fuzzSnapshot},
    {"trace", fuzzTrace},
    {"string", fuzzString},
    {"mtg", fuzzMtg},
    {"roots", fuzzRoots},
    {"points", fuzzPoints},
    {"terrain", fuzzTerrain},
    {"vti", fuzzVti},
    {"forest", fuzzForest},
};

}  // namespace espalier::fuzz
