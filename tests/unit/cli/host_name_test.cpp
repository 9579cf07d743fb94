// How a program calls itself to a device: user, machine and program in the bytes that a device keeps.
#include "host-tools/client/host_name.h"

#include <gtest/gtest.h>

#include "firmware/link/messages.h"

namespace thimble::test {
namespace {

using host::host_name;

TEST(HostName, UserMachineAndProgram) {
  EXPECT_EQ(host_name("alice", "lab", "thimble upload"), "alice@lab thimble upload");
  EXPECT_EQ(host_name("bob", "pc.example.org", "python"), "bob@pc python");
}

TEST(HostName, CutsTheMachineBeforeTheProgram) {
  EXPECT_EQ(host_name("alice", "workstation-3", "python"), "alice@workstation python");
  EXPECT_EQ(host_name("alice", "workstation-3", "thimble param save"), "alice@wo thimble param s");
  EXPECT_EQ(host_name("alice", "lab", std::string(100, 'p')), "alice@la " + std::string(15, 'p'));
}

// What a device takes.
TEST(HostName, IsPrintableAndShort) {
  for (int byte = 0; byte < 256; ++byte) {
    const std::string odd(40, static_cast<char>(byte));
    for (const std::string& name :
         {host_name(odd, "lab", "python"), host_name("al", odd, "python"), host_name("al", "lab", odd)}) {
      EXPECT_LE(name.size(), firmware::link::kHostNameBytes);
      EXPECT_GE(name.size(), 1U);
      for (const char letter : name) EXPECT_TRUE(letter >= 0x20 && letter <= 0x7E) << byte;
    }
  }
}

TEST(HostName, OfThisProgram) {
  EXPECT_NE(host_name("").find("@"), std::string::npos);
  EXPECT_NE(host_name("x").find(" x"), std::string::npos);
}

}  // namespace
}  // namespace thimble::test
