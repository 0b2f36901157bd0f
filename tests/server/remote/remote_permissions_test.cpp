#include "server/remote/remote_permissions.h"

#include <fstream>

#include "tests/server/server_fixture.h"

namespace espalier::server::remote_permissions_test {
namespace {

using Words = std::vector<std::string>;

std::string problemOf(const std::string& name, const Words& texts) {
  const auto read = readSpawnCommand(name, texts);
  return read ? std::string() : read.error();
}

TEST(RemotePermissions, TheWordsOfACommandAreDividedWithoutAShell) {
  const SpawnCommand command = readSpawnCommand("light", {"/bin/echo 'a b'\"c\" $HOME ; \"\" *"}).value();
  EXPECT_EQ(command.words, (Words{"/bin/echo", "a bc", "$HOME", ";", "", "*"}));
  EXPECT_FALSE(command.takesArguments);
  EXPECT_EQ(readSpawnCommand("light", {"/bin/echo", "a b"}).value().words, (Words{"/bin/echo", "a b"}));
  EXPECT_EQ(readSpawnCommand("light", {"sh"}).value().words.front().front(), '/');
}

TEST(RemotePermissions, ArgumentsOfClientsNeedTheOperatorsDots) {
  const SpawnCommand command = readSpawnCommand("open", {"/bin/echo -n ..."}).value();
  EXPECT_EQ(command.words, (Words{"/bin/echo", "-n"}));
  RemotePermissions permissions;
  permissions.spawn = {{"open", command}, {"closed", readSpawnCommand("closed", {"/bin/echo"}).value()}};
  EXPECT_FALSE(permissions.problemOfName("open", true));
  EXPECT_FALSE(permissions.problemOfName("closed", false));
  EXPECT_EQ(permissions.problemOfName("closed", true).value_or(""),
            "the command 'closed' takes no arguments from clients. Use \"configuration\", or let the operator end it "
            "with ' ...' under [spawn].");
  EXPECT_EQ(permissions.problemOfName("close", false).value_or(""),
            "'close' is not a command that the operator of the server lists under [spawn]. Did you mean 'closed'? "
            "Available: closed, open.");
}

TEST(RemotePermissions, ACommandThatCannotStartIsAMistake) {
  const TemporaryFolder folder;
  const std::string script = folder.path() + "/light.py";
  EXPECT_EQ(problemOf("light", {"python3 " + script}),
            "the command 'light' of [spawn] names the file '" + script + "', which is not there: give its path.");
  std::ofstream(script) << "print()\n";
  EXPECT_EQ(problemOf("light", {"python3 " + script}), "");
  EXPECT_EQ(problemOf("light", {script}), "the command 'light' of [spawn] names the program '" + script +
                                              "', which is not there or not executable: give the path of its file.");
  EXPECT_EQ(problemOf("light", {folder.path()}).substr(0, 50), "the command 'light' of [spawn] names the program '");
  EXPECT_EQ(problemOf("light", {"/bin/echo 'a"}),
            "the command 'light' of [spawn] has a quote that does not end: add the second one.");
  EXPECT_EQ(problemOf("light", {""}), "the command 'light' of [spawn] is empty: write a program and its arguments.");
  EXPECT_EQ(problemOf("light", {"..."}), problemOf("light", {""}));
  EXPECT_EQ(problemOf("li/ght", {"/bin/echo"}),
            "the command 'li/ght' of [spawn] has an unusual name: use letters, digits, '-' and '_', at most 64.");
}

TEST(RemotePermissions, OnlyListedAddressesAreDialled) {
  RemotePermissions permissions;
  EXPECT_FALSE(permissions.mayDial("127.0.0.1:4000"));
  permissions.addresses = {"127.0.0.1:4000"};
  EXPECT_TRUE(permissions.mayDial("127.0.0.1:4000"));
  EXPECT_FALSE(permissions.mayDial("127.0.0.1:40000"));
  EXPECT_FALSE(permissions.mayDial("127.0.0.1:400"));
  permissions.addresses = {"any"};
  EXPECT_TRUE(permissions.mayDial("10.0.0.1:80"));
}

}  // namespace
}  // namespace espalier::server::remote_permissions_test
