// view: the web page.
#include <fmt/format.h>

#include <cstdio>

#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/lab/arm_choice.h"
#include "host-tools/viewer/view.h"

namespace thimble::host {

void view(const Common& common, const Remote& remote, const ViewChoice& choice) {
  ViewOptions options;
  options.device = remote.device;
  options.device_options = options_of(remote);
  options.scene = choice.scene;
  options.arm = choice.arm;
  if (!choice.scene.empty()) options.arm_data = other_arm(choice.arm);
  options.arms = static_cast<std::uint8_t>(choice.arms);
  options.scenes = choice.scenes;
  options.listen = choice.listen;
  options.port = choice.port;
  options.version = THIMBLE_VERSION;
  view(options, [&](const std::string& url, const std::string& device) {
    if (common.json) {
      Json json = document("view");
      json["url"] = url;
      json["device"] = device;
      print_line(json);
    } else {
      say("{}\n", url);
      std::fflush(stdout);
    }
    if (!choice.browser) return;
    const std::string failed = open_browser(url);
    if (!failed.empty() && !common.json)
      say(stderr, "thimble: no browser was opened: {}\n  remedy: open the address above\n", failed);
  });
}

}  // namespace thimble::host
