// Access rights: names of this machine and of others, origins, tokens, cookies.
#include "host-tools/viewer/access.h"

#include <gtest/gtest.h>

namespace thimble::host {
namespace {

TEST(Access, Targets) {
  EXPECT_EQ(parse_target("/").path, "/");
  EXPECT_EQ(parse_target("/live?token=abc").path, "/live");
  EXPECT_EQ(parse_target("/live?token=abc").token, "abc");
  EXPECT_EQ(parse_target("/?a=b&token=abc&c").token, "abc");
  EXPECT_EQ(parse_target("/?xtoken=abc&&").token, "");
  EXPECT_EQ(parse_target("?").token, "");
  EXPECT_EQ(parse_target("").path, "");
}

TEST(Access, Secrets) {
  EXPECT_TRUE(same_secret("abc", "abc"));
  EXPECT_FALSE(same_secret("abd", "abc"));
  EXPECT_FALSE(same_secret("", "abc"));
  EXPECT_FALSE(same_secret("abcd", "abc"));
}

TEST(Access, OnlyLoopbackNames) {
  for (const char* host : {"127.0.0.1:8000", "localhost:8000", "LocalHost:8000", "[::1]:8000"})
    EXPECT_TRUE(is_loopback_host(host, 8000)) << host;
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:8001", "localhost", "example.org:8000", "localhost.example.org:8000",
        "127.0.0.1:8000@example.org", "127.0.0.1:80000", "::1:8000", "10.0.0.1:8000"})
    EXPECT_FALSE(is_loopback_host(host, 8000)) << host;
  EXPECT_TRUE(is_loopback_host("localhost", 80));
}

TEST(Access, OwnOrigins) {
  EXPECT_TRUE(is_own_origin("", "127.0.0.1:8000")) << "no browser";
  EXPECT_TRUE(is_own_origin("http://127.0.0.1:8000", "127.0.0.1:8000"));
  EXPECT_TRUE(is_own_origin("http://LOCALHOST:8000", "localhost:8000"));
  for (const char* origin : {"null", "http://127.0.0.1", "http://127.0.0.1:8001", "https://127.0.0.1:8000",
                             "http://127.0.0.1:8000.example.org", "http://localhost:8000", "127.0.0.1:8000"})
    EXPECT_FALSE(is_own_origin(origin, "127.0.0.1:8000")) << origin;
}

TEST(Access, Cookies) {
  EXPECT_EQ(cookie("thimble-80=abc", "thimble-80"), "abc");
  EXPECT_EQ(cookie("a=b; thimble-80=abc; c=d", "thimble-80"), "abc");
  EXPECT_EQ(cookie("thimble-8000=abc", "thimble-80"), "");
  EXPECT_EQ(cookie("x-thimble-80=abc;;", "thimble-80"), "");
  EXPECT_EQ(cookie("", "thimble-80"), "");
}

}  // namespace
}  // namespace thimble::host
