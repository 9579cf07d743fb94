#include "board/linux/run_mark.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "board/linux/open_file.h"

namespace thimble::board {
namespace {

constexpr char kRuns = 'r', kEnded = 'e';

bool put(const std::filesystem::path& file, char mark) {
  return ::pwrite(open_file(file, O_WRONLY | O_CREAT).get(), &mark, 1, 0) == 1;
}

}  // namespace

RunMark::RunMark(const std::filesystem::path& folder) {
  if (folder.empty()) return;
  file_ = folder / "run";
  if (const Descriptor file(::open(file_.c_str(), O_RDONLY | O_CLOEXEC)); file.is_open()) {
    char mark = kRuns;
    (void)!::read(file.get(), &mark, 1);
    before_ = mark == kEnded ? Before::kEnded : Before::kCrashed;
  }
  if (!put(file_, kRuns)) throw std::system_error(errno, std::generic_category(), file_.string());
}

RunMark::~RunMark() {
  try {
    if (!file_.empty()) (void)put(file_, kEnded);
  } catch (const std::system_error&) {  // the next start takes this run for one that crashed
  }
}

}  // namespace thimble::board
