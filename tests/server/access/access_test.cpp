#include "server/access/access.h"

#include <gtest/gtest.h>

#include "server/access/token.h"

namespace espalier::server::access_test {
namespace {

using protocol::Role;
using protocol::Roles;
using namespace std::chrono_literals;

const WallTime kPast = std::chrono::system_clock::now() - 1h;
const WallTime kFuture = std::chrono::system_clock::now() + 1h;

Token tokenUntil(std::string name, std::string_view text, const Roles& roles, WallTime expires) {
  Token token = tokenOf(std::move(name), text, roles);
  token.expires = expires;
  return token;
}

TEST(Roles, AControllerMayDoEverythingAndTheOthersTheirPart) {
  EXPECT_TRUE(Roles{Role::Controller}.allows(Role::Viewer));
  EXPECT_TRUE(Roles{Role::Controller}.allows(Role::Environment));
  EXPECT_TRUE(Roles{Role::Viewer}.allows(Role::Anyone));
  EXPECT_FALSE(Roles{Role::Viewer}.allows(Role::Controller));
  EXPECT_FALSE(Roles{Role::Viewer}.allows(Role::Environment));
  EXPECT_FALSE(Roles{Role::Environment}.allows(Role::Viewer));
  EXPECT_FALSE(Roles{}.allows(Role::Viewer));
}

TEST(Roles, GrantedAreThoseAskedForThatThereAre) {
  const Roles all{Role::Controller};
  EXPECT_EQ(all.granted({"viewer"}), Roles{Role::Viewer});
  EXPECT_EQ(all.granted({}), all);
  EXPECT_EQ((Roles{Role::Viewer, Role::Environment}.granted({"controller", "environment"})), Roles{Role::Environment});
  EXPECT_TRUE(Roles{Role::Viewer}.granted({"controller", "king"}).isEmpty());
  EXPECT_EQ((Roles{Role::Controller, Role::Viewer}.text()), "viewer, controller");
}

TEST(Access, AServerWithoutTokensGrantsEveryRole) {
  const Access access({});
  EXPECT_EQ(access.grant("", {}).value().roles, Roles{Role::Controller});
  EXPECT_EQ(access.grant("any", {"viewer"}).value().roles, Roles{Role::Viewer});
}

TEST(Access, ATokenGrantsTheRolesThatItHas) {
  const Access access({tokenOf("alice", "a", {Role::Controller}), tokenOf("screen", "s", {Role::Viewer})});
  EXPECT_EQ(access.grant("a", {}).value().roles, Roles{Role::Controller});
  EXPECT_EQ(access.grant("s", {"controller", "viewer"}).value().roles, Roles{Role::Viewer});
  EXPECT_EQ(access.grant("s", {"viewer"}).value().token->name, "screen");
  EXPECT_EQ(access.grant("s", {"controller"}).error(),
            "The token 'screen' has the roles viewer, and this program asks for others. Use another token; or let the "
            "program ask for one of these roles in params.roles of hello.");
  EXPECT_EQ(access.grant("", {}).error(),
            "This server asks for a token (params.token of hello), and none came. Its operator has one.");
  for (const char* wrong : {"b", "as", "A"}) {
    EXPECT_EQ(access.grant(wrong, {}).error(),
              "The server does not know this token. It is mistyped, was taken away, or is of an earlier start of the "
              "server: use the token, or the link, that the server has now.");
  }
}

TEST(Access, ATokenWhoseHashBeginsAlikeGrantsNothing) {
  const Access access({tokenOf("alice", "a", {Role::Controller})});
  int alike = 0;
  for (int i = 0; alike < 3; ++i) {
    const std::string other = "other " + std::to_string(i);
    if (hashOfToken(other)[0] == hashOfToken("a")[0]) {
      ++alike;
      EXPECT_FALSE(access.grant(other, {}).has_value()) << other;
    }
  }
}

TEST(Access, AnExpiredTokenGrantsNothingAndEndsWhatItGranted) {
  EXPECT_EQ(Access({tokenUntil("old", "o", {Role::Viewer}, kPast)}).grant("o", {}).error().substr(0, 28),
            "The token 'old' expired at 2");
  Access access({tokenUntil("alice", "a", {Role::Viewer}, kFuture)});
  const Grant grant = access.grant("a", {}).value();
  EXPECT_FALSE(access.problemOf(grant));
  Grant later = grant;
  later.token = std::make_shared<const Token>(tokenUntil("alice", "a", {Role::Viewer}, kPast));
  EXPECT_TRUE(access.problemOf(later));
}

TEST(Access, AReplacedTokenEndsAndTheOthersGoOn) {
  Access access({tokenOf("alice", "a", {Role::Controller}), tokenOf("bob", "b", {Role::Viewer})});
  const Grant alice = access.grant("a", {}).value();
  const Grant bob = access.grant("b", {}).value();
  // bob's token was given more roles: he connects again to have them
  EXPECT_TRUE(access.replace({tokenOf("alice", "a", {Role::Controller}), tokenOf("bob", "b", {Role::Controller})}));
  EXPECT_FALSE(access.problemOf(alice));
  EXPECT_EQ(access.problemOf(bob).value_or(""),
            "The operator has changed or removed the token 'bob'. Connect again with a token of the server.");
}

TEST(Access, TheLastTokenIsNotTakenAway) {
  Access access({tokenOf("alice", "a", {Role::Controller})});
  EXPECT_FALSE(access.replace({}));
  EXPECT_FALSE(access.grant("", {}));
  EXPECT_TRUE(access.grant("a", {}));
}

TEST(Access, TokensEndWhatAnOpenServerGranted) {
  Access access({});
  const Grant open = access.grant("", {}).value();
  EXPECT_TRUE(access.replace({tokenOf("alice", "a", {Role::Controller})}));
  EXPECT_EQ(access.problemOf(open).value_or(""), "The server asks for a token now. Connect again with one.");
}

TEST(Token, ALineIsReadAsItIsWritten) {
  Token token = tokenOf("alice", "secret", {Role::Controller, Role::Viewer});
  token.expires = readTime("2027-01-31");
  const std::string line = toText(token);
  EXPECT_EQ(line,
            "viewer,controller sha256:2bb80d537b1da3e38bd30361aa855686bde0eacd7162fef6a25fe97bf527a25b "
            "expires:2027-01-31T00:00:00Z");
  const Token again = readToken("alice", line).value();
  EXPECT_EQ(again.hash, token.hash);
  EXPECT_EQ(again.roles, token.roles);
  EXPECT_EQ(again.expires, token.expires);
}

TEST(Token, AWrongLineIsRefusedWithTheReason) {
  const std::string hash = " sha256:" + std::string(64, 'a');
  const auto problem = [](const std::string& name, const std::string& line) {
    const auto read = readToken(name, line);
    return read ? std::string("(read)") : read.error();
  };
  EXPECT_EQ(problem("a b", "viewer" + hash),
            "the token 'a b' of [tokens] has an unusual name: use letters, digits, '-' and '_', at most 64.");
  EXPECT_EQ(problem("a", "king" + hash),
            "the token 'a' of [tokens] has 'king', which is neither a list of roles (controller,viewer,environment) "
            "nor sha256: nor expires:. 'espalier token new' writes the line.");
  EXPECT_EQ(problem("a", "viewer sha256:12"),
            "the token 'a' of [tokens] needs one sha256: with 64 digits 0-9a-f behind it. 'espalier token new' writes "
            "the line.");
  EXPECT_EQ(problem("a", "viewer" + hash + " expires:2027-02-31"),
            "the token 'a' of [tokens] has 'expires:2027-02-31', which is no time: write expires:2027-01-31 or "
            "expires:2027-01-31T12:00:00Z.");
  EXPECT_EQ(problem("a", hash),
            "the token 'a' of [tokens] needs its roles and sha256:. 'espalier token new' writes the line.");
  EXPECT_EQ(problem("a", "viewer"), problem("a", hash));
  EXPECT_NE(problem("a", "viewer viewer" + hash), "(read)");
  EXPECT_NE(problem("a", "viewer," + hash), "(read)");
  EXPECT_NE(problem("a", "viewer" + hash + hash), "(read)");
  EXPECT_EQ(problem("a", "viewer" + hash), "(read)");
}

TEST(Token, TwoNewOnesDiffer) {
  EXPECT_NE(drawTokenText(), drawTokenText());
  EXPECT_EQ(drawTokenText().size(), 9U + 64U);
}

}  // namespace
}  // namespace espalier::server::access_test
