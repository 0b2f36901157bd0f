// An environment that stops growth at the height 6:
//   espalier run clients/gallery/light-tree --environment stdio:./ceiling -o tree.png
#include "clients/cpp/environment.h"

using espalier::client::Environment;
using espalier::client::EnvironmentDescription;
using espalier::client::Queries;
using espalier::client::Replies;

struct Ceiling : Environment {
  void respond(const Queries& queries, Replies& replies) override {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      replies.set(i, {queries[i].position[1] < 6 ? 1.0 : 0.0});
    }
  }
};

int main(int count, char** arguments) {
  EnvironmentDescription ceiling;
  ceiling.name = "ceiling";
  ceiling.summary = "Answers 1 below the height 6 and 0 above it.";
  ceiling.needs.position = true;
  return espalier::client::serveEnvironment<Ceiling>(ceiling, count, arguments);
}
