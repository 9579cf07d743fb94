// The key of a board in a file: 64 hexadecimal digits, for its owner only.
#pragma once

#include <filesystem>

#include "host-tools/client/service_client.h"

namespace thimble::host {

// $XDG_CONFIG_HOME/thimble/key, or ~/.config/thimble/key.
[[nodiscard]] std::filesystem::path default_key_file();

// Errors: kPermission, others may read or write it (`key-not-private`), or you may not read it; kBadInput, `not-a-key`.
[[nodiscard]] link::Key read_key(const std::filesystem::path& file);

// A new key from the system's random numbers, in a new file with mode 0600; its folder is made. Errors: kPermission; kRefused, there is such
// a file (`file-exists`), or it cannot be written.
[[nodiscard]] link::Key make_key(const std::filesystem::path& file);

// Proves with the key in the file, which it reads when a device wants a proof. Where there is no such file it throws kPermission `no-key`.
[[nodiscard]] Prover prove_with(std::filesystem::path file);

}  // namespace thimble::host
