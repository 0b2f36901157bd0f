#include "server/network/http_pages.h"

#include <gtest/gtest.h>

#include "server/server_core.h"

namespace espalier::server::http_pages_test {
namespace {

TEST(HttpPages, BrowsersConnectFromPagesOfTheHostItselfOrAnAllowedOne) {
  EXPECT_TRUE(isOriginAllowed("", "127.0.0.1:8080", true, {}));  // a program
  EXPECT_TRUE(isOriginAllowed("http://127.0.0.1:8080", "127.0.0.1:8080", true, {}));
  EXPECT_TRUE(isOriginAllowed("https://plants.example", "plants.example", false, {}));
  EXPECT_FALSE(isOriginAllowed("http://127.0.0.1:8081", "127.0.0.1:8080", true, {}));
  EXPECT_FALSE(isOriginAllowed("null", "127.0.0.1:8080", true, {}));
  EXPECT_FALSE(isOriginAllowed("http://", "", false, {}));
  EXPECT_TRUE(isOriginAllowed("https://elsewhere.example", "127.0.0.1:8080", true, {"https://elsewhere.example"}));
  EXPECT_FALSE(
      isOriginAllowed("https://elsewhere.example.evil", "127.0.0.1:8080", true, {"https://elsewhere.example"}));
}

TEST(HttpPages, AForeignNameThatLeadsToThisMachineIsNotThisMachine) {
  // a page of evil.example whose name was made to lead here after it was loaded
  EXPECT_FALSE(isOriginAllowed("http://evil.example:8080", "evil.example:8080", true, {}));
  EXPECT_TRUE(isOriginAllowed("http://localhost:8080", "localhost:8080", true, {}));
  EXPECT_TRUE(isOriginAllowed("http://[::1]:8080", "[::1]:8080", true, {}));
  EXPECT_FALSE(isHostAllowed("evil.example:8080", true));
  EXPECT_FALSE(isHostAllowed("localhost.evil.example", true));
  EXPECT_FALSE(isHostAllowed("127.0.0.1.evil.example", true));
  EXPECT_TRUE(isHostAllowed("evil.example:8080", false));
  EXPECT_TRUE(isHostAllowed("127.0.0.1", true));
}

TEST(HttpPages, ThePathDecidesAndWhatFollowsItDoesNot) {
  ServerOptions options;
  options.logLevel = "off";
  options.pages = {{"/", "text/html", "the page"}, {"/a.js", "text/javascript", "its script"}};
  ServerCore core(options);
  ASSERT_NE(pageOf("/", core).file, nullptr);
  EXPECT_EQ(pageOf("/", core).file->content, "the page");
  EXPECT_EQ(pageOf("/a.js?x=1", core).file->content, "its script");
  EXPECT_NE(pageOf("/a.js", core).file->tag, pageOf("/", core).file->tag);
  EXPECT_EQ(pageOf("/a.js", core).type, "text/javascript");
  EXPECT_EQ(pageOf("/health?x=1", core).body.find("{\"status\":\"ok\""), 0U);
  EXPECT_EQ(pageOf("/metrics", core).status, 200U);
  EXPECT_EQ(pageOf("/../etc/passwd", core).status, 404U);
  core.beginShutdown();
  EXPECT_EQ(pageOf("/health", core).status, 503U);
}

TEST(HttpPages, GzipIsSentToThoseWhoReadIt) {
  EXPECT_TRUE(acceptsGzip("gzip, deflate, br"));
  EXPECT_TRUE(acceptsGzip("br;q=1.0, GZIP;q=0.5"));
  EXPECT_FALSE(acceptsGzip(""));
  EXPECT_FALSE(acceptsGzip("identity"));
  EXPECT_FALSE(acceptsGzip("xgzip"));
  EXPECT_FALSE(acceptsGzip("gzip;q=0"));
  EXPECT_FALSE(acceptsGzip("gzip; q=0.000, br"));
  EXPECT_FALSE(acceptsGzip(";;,=\"gzip"));
}

TEST(HttpPages, AFileIsKnownByItsWholeTag) {
  EXPECT_TRUE(hasFile(R"("7", W/"12")", R"(W/"12")"));
  EXPECT_FALSE(hasFile(R"(W/"123")", R"(W/"12")"));
  EXPECT_FALSE(hasFile("", R"(W/"12")"));
  EXPECT_FALSE(hasFile("W/", ""));
}

}  // namespace
}  // namespace espalier::server::http_pages_test
