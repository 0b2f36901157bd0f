#pragma once

namespace CLI {
class App;
}

namespace espalier::command {

/// Each function adds its subcommand with options and help to the program. When the command line names the subcommand,
/// its callback runs it and stores the exit status in `status`: 0 success, 1 the command failed (bad model, environment
/// gone), 2 wrong command line. stdout carries results only; everything else goes to stderr. References must outlive
/// parsing.
void addDerive(CLI::App& program, int& status);
void addCheck(CLI::App& program, int& status);
void addRun(CLI::App& program, int& status);
void addExport(CLI::App& program, int& status);
void addWatch(CLI::App& program, int& status);
void addFormat(CLI::App& program, int& status);
void addGrowth(CLI::App& program, int& status);
void addReference(CLI::App& program, int& status);
void addConvert(CLI::App& program, int& status);
void addDisassemble(CLI::App& program, int& status);
void addExplain(CLI::App& program, int& status);
void addServe(CLI::App& program, int& status);
void addEnvironment(CLI::App& program, int& status);
void addEvolve(CLI::App& program, int& status);
void addForest(CLI::App& program, int& status);
void addSweep(CLI::App& program, int& status);
void addInfer(CLI::App& program, int& status);
void addLanguageServer(CLI::App& program, int& status);
void addField(CLI::App& program, int& status);
void addPoints(CLI::App& program, int& status);
void addReplay(CLI::App& program, int& status);
void addConformance(CLI::App& program, int& status);
void addTraits(CLI::App& program, int& status);
void addValidate(CLI::App& program, int& status);
void addConnect(CLI::App& program, int& status);
void addLoad(CLI::App& program, int& status);
void addStatus(CLI::App& program, int& status);
void addToken(CLI::App& program, int& status);
void addBackup(CLI::App& program, int& status);
void addRestore(CLI::App& program, int& status);
void addSelfTest(CLI::App& program, int& status);

}  // namespace espalier::command
