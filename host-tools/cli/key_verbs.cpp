// key set and remove.
#include <filesystem>

#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/key_file.h"

namespace thimble::host {

void key_set(const Common& common, const Remote& remote, const std::filesystem::path& file) {
  const std::filesystem::path place = file.empty() ? remote.key : file;
  Device device = open_device(common, remote);
  const bool is_new = !std::filesystem::exists(place);
  const link::Key key = is_new ? make_key(place) : read_key(place);
  try {
    device.set_key(key);
  } catch (const Error& error) {
    if (!is_new) throw;
    if (error.code != ExitCode::kLinkLost) {  // the device has refused it
      std::filesystem::remove(place);
      throw;
    }
    throw Error(error.code, error.name, error.cause + "; it may have the key in " + place.string(),
                "keep that file; see `thimble info`, and repeat the command when the link is back");
  }
  if (common.json) {
    Json json = document("key");
    json["key"] = "set";
    json["file"] = place.string();
    json["new_file"] = is_new;
    print(json);
  } else {
    say("the key is set: only programs that have {} command the device\n", place.string());
  }
}

void key_remove(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  device.remove_key();
  if (common.json) {
    Json json = document("key");
    json["key"] = "none";
    print(json);
  } else {
    say("there is no key: every program on the link may command the device\n");
  }
}

}  // namespace thimble::host
